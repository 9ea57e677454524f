"""How a run ends, by what the engine says."""

import pytest

from flexbe_widget.core.run_watch import (
    SILENCE_S,
    START_LIMIT_S,
    Code,
    End,
    Ending,
    RunWatch,
    is_busy,
)

MINE, OTHER = 7, 8


def fed(*statuses):
    """Return a watch of MINE after some statuses, and the first ending among them."""
    watch = RunWatch(MINE)
    for code, behavior_id, *args in statuses:
        ending = watch.on_status(code.value, behavior_id, tuple(args))
        if ending is not None:
            return ending
    return None


STARTED = (Code.STARTED, MINE)

ROWS = [
    ("started", [STARTED], None),
    ("finished", [STARTED, (Code.FINISHED, MINE, "done")], Ending(End.FINISHED, "done")),
    (
        "preempted",
        [STARTED, (Code.FINISHED, MINE, "preempted")],
        Ending(End.PREEMPTED, "preempted"),
    ),
    ("failed", [STARTED, (Code.FAILED, MINE)], Ending(End.FAILED)),
    ("refused", [(Code.ERROR, MINE)], Ending(End.REFUSED)),
    ("the engine is restarted before it began", [(Code.READY, 0)], Ending(End.RESTARTED)),
    ("the engine is restarted in between", [STARTED, (Code.READY, 0)], Ending(End.RESTARTED)),
    ("a second request for it is refused", [STARTED, (Code.ERROR, MINE)], None),
    (
        "switched to another version, which ends",
        [STARTED, (Code.SWITCHING, MINE), (Code.STARTED, OTHER), (Code.FINISHED, OTHER, "done")],
        Ending(End.FINISHED, "done"),
    ),
    (
        "a switch of another behavior",
        [STARTED, (Code.SWITCHING, OTHER), (Code.STARTED, OTHER)],
        None,
    ),
    ("another behavior is refused", [(Code.ERROR, OTHER)], None),
    ("a launcher knows no behavior", [(Code.ERROR, 0)], None),
    ("another behavior ends", [STARTED, (Code.FINISHED, OTHER, "done")], None),
    ("its last run ends late", [(Code.FINISHED, MINE, "done"), STARTED], None),
    ("it is switched to a new version", [STARTED, (Code.SWITCHING, MINE)], None),
]


@pytest.mark.parametrize(
    ("statuses", "ending"), [row[1:] for row in ROWS], ids=[row[0] for row in ROWS]
)
def test_statuses_end_a_run(statuses, ending):
    assert fed(*statuses) == ending


def test_a_silent_engine_ends_a_run():
    watch = RunWatch(MINE)
    assert watch.on_time(1.0, SILENCE_S - 0.1) is None
    assert watch.on_time(1.0, SILENCE_S + 0.1) == Ending(End.LOST)


def test_a_run_that_is_never_started_ends():
    watch = RunWatch(MINE)
    assert watch.on_time(START_LIMIT_S + 1, 0.0) == Ending(End.LATE)
    watch.on_status(Code.STARTED.value, MINE, ())
    assert watch.on_time(START_LIMIT_S + 1, 0.0) is None


def test_an_engine_is_busy_while_it_runs_or_switches():
    assert [code for code in Code if is_busy(code.value)] == [Code.STARTED, Code.SWITCHING]
