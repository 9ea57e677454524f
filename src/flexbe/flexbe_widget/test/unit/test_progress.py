"""Which progress of an action be_launcher prints."""

from flexbe_widget.core.run_watch import Progress


def lines(*reports):
    progress = Progress("InsertCable")
    return [line for report in reports if (line := progress.line(*report))]


def test_each_step_has_a_line():
    assert lines(("g1", "approach", 10.0), ("g1", "approach", 12.0), ("g1", "push", 50.0)) == [
        "InsertCable 10 %: approach",
        "InsertCable 50 %: push",
    ]


def test_a_long_step_has_a_line_for_each_quarter():
    found = lines(*(("g1", f"push, {share} mm", float(share)) for share in range(101)))
    assert [line.split()[1] for line in found] == ["0", "25", "50", "75", "100"]


def test_another_goal_begins_again():
    assert len(lines(("g1", "push", 90.0), ("g2", "push", 90.0))) == 2
