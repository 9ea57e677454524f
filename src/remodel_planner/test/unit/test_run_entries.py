"""A run's record as a console gets it."""

from test_run_explanation import RUN

from remodel_run.record import Kind
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import entries_of
from remodel_supervision.core.runs.events import (
    OperationEnded,
    Part,
    RunBegun,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.ros.server.record_server import entry_message

BEGUN = RunBegun("house", "cabinet", "cell", ("W1", "W2"))


def test_positions_have_no_gaps_and_entries_are_only_added():
    whole = entries_of((BEGUN, *RUN))
    assert [entry.position for entry in whole] == list(range(1, len(whole) + 1))
    for count in range(1, len(RUN)):
        part = entries_of((BEGUN, *RUN[:count]))
        assert part == whole[: len(part)]


def test_a_behavior_is_published_in_the_order_of_time_with_what_was_measured():
    measured = (("depth", "0.0139"), ("peak_force", "5.5"), ("note", "text"))
    operation = Operation("/A", "InsertCable", "inserted", 0, "", 9.0, 4.0, measurements=measured)
    picture = "W1-1-whole_6.000_wrist.jpg"
    entries = entries_of(
        (
            BEGUN,
            TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", chart="", at_s=4.0),
            OperationEnded("W1", operation),
            TaskEnded("W1", "finished", 10.0, True, path=(), pictures=(picture,)),
        )
    )
    kinds = [(entry.kind, entry.time_s) for entry in entries]
    assert kinds == [
        (Kind.RUN, 0.0),
        (Kind.TASK, 4.0),
        (Kind.STATE, 5.0),
        (Kind.PICTURE, 6.0),
        (Kind.RESULT, 9.0),
        (Kind.STATE, 10.0),
        (Kind.TASK, 10.0),
    ]
    assert entries[3].text == "wrist"
    assert entries[4].values == (("depth_m", 0.0139), ("peak_force_n", 5.5))
    message = entry_message(entries[4])
    assert (message.kind, message.stamp.to_sec()) == ("result", 9.0)
    assert (message.names, message.values) == (["depth_m", "peak_force_n"], [0.0139, 5.5])


def test_failures_come_with_their_decision():
    kinds = [entry.kind for entry in entries_of((BEGUN, *RUN))]
    assert kinds[kinds.index(Kind.FAILURE) + 1] == Kind.DECISION
    assert kinds.count(Kind.OPERATOR) == 4
