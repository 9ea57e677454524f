"""Certificates as the editor shows them."""

from flexbe_synthesizer.core.export.certificate import Certificate, ErrorEnd, StateBound
from flexbe_synthesizer.core.library.signature import Effect
from remodel_console.core.inspection import certificate_html

CODE = frozenset({"error_code"})
NOTHING = frozenset()


def certificate(longest_s):
    return Certificate(
        "Task",
        "p",
        longest_s=longest_s,
        states=(StateBound("Place/Insert", 3, 30.0, 90.0), StateBound("Log", None, None, None)),
        errors=(
            ErrorEnd("Place/Insert", "failed", "301, 304", "Withdraw", ends=("failed",)),
            ErrorEnd("Place/Insert", "refused", "any", "Again", ends=("done", "failed")),
        ),
        effects=(Effect("done", NOTHING, CODE), Effect("failed", CODE, CODE)),
        assumed=("p/<State>",),
    )


def test_all_that_is_certified_is_shown():
    shown = certificate_html(certificate(90.5))
    assert "A run takes at most 90.5 s." in shown
    assert "<td>Place/Insert</td><td>3</td><td>30 s</td><td>90 s</td>" in shown
    assert "<td>Log</td><td>unbounded</td>" in shown
    assert "<td>failed 301, 304</td><td>Withdraw → failed</td>" in shown
    assert "<td>refused</td><td>Again → done, failed</td>" in shown
    assert "<td>done</td><td></td><td>error_code</td>" in shown
    assert "<td>failed</td><td>error_code</td><td></td>" in shown
    assert "p/&lt;State&gt;" in shown


def test_a_run_without_a_limit_is_named():
    assert "The time of a run has no bound" in certificate_html(certificate(None))
