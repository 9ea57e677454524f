"""The record of a run: what was so at each moment of it."""

import pytest
from remodel_msgs.msg import RunEntry
from remodel_msgs.srv import GetRunResponse

from remodel_console.core.record import Record, in_chart_terms, value_words
from remodel_console.ros import use_case_link
from remodel_run.record import Entry, Kind, entry_words


def entry(position, time_s, kind, **fields):
    return Entry(position, time_s, kind, **fields)


RECORD = Record(
    (
        entry(1, 100.0, Kind.RUN, text="begins"),
        entry(2, 101.0, Kind.TASK, task="W1", text="running"),
        entry(3, 101.5, Kind.STATE, task="W1", state_path="/Locate"),
        entry(4, 102.0, Kind.FEEDBACK, task="W1", values=(("completed_percentage", 40.0),)),
        entry(5, 103.0, Kind.STATE, task="W1", state_path="/Insert"),
        entry(6, 104.0, Kind.RESULT, task="W1", text="jammed", values=(("force_n", 22.0),)),
        entry(7, 104.0, Kind.FAILURE, task="W1", fault="insertion_jammed", has_picture=True),
        entry(8, 104.1, Kind.DECISION, task="W1", text="replan", because="two parts jammed"),
        entry(9, 105.0, Kind.TASK, task="W2", text="running"),
        entry(10, 106.0, Kind.STATE, task="W2", state_path="/Locate"),
        entry(11, 107.0, Kind.STATE, task="W2", state_path=""),
        entry(12, 108.0, Kind.TASK, text="between tasks"),
    )
)


def test_times_are_those_of_the_run():
    assert RECORD.length_s == 8
    assert RECORD.offset_s(RECORD.entries[4]) == 3
    assert [RECORD.at(t) for t in (-1, 0, 2.5, 4.0, 99)] == [0, 0, 3, 6, 11]
    assert Record(()).length_s == 0


def test_entries_without_a_time_happened_with_those_beside_them():
    times = (0.0, 0.0, 50.0, 0.0, 52.0, 51.0, 53.0)
    record = Record(tuple(entry(i, t, Kind.TASK) for i, t in enumerate(times, start=1)))
    assert record.offsets_s == (0, 0, 0, 0, 2, 2, 3)
    assert record.at(0) == 3
    assert record.at(2.5) == 5
    assert Record((entry(1, 0.0, Kind.RUN),)).length_s == 0


def test_a_moment_has_task_state_and_feedback():
    moment = RECORD.moment(3)
    assert (moment.task, moment.state_path, moment.passed) == ("W1", "/Locate", ("/Locate",))
    assert moment.feedback == RECORD.entries[3]
    assert moment.reasons == ()
    assert moment.picture == 0


def test_a_visit_is_that_of_the_state_of_the_moment():
    assert RECORD.visit_s(3) == (101.5, 103.0)
    assert RECORD.visit_s(6) == (103.0, 106.0)
    again = (
        entry(1, 100.0, Kind.STATE, task="W1", state_path="/Insert"),
        entry(2, 102.0, Kind.STATE, task="W1", state_path="/Lay down"),
        entry(3, 103.0, Kind.FAILURE, task="W1", state_path="/Insert"),
        entry(4, 104.0, Kind.STATE, task="W1", state_path="/Insert"),
        entry(5, 109.0, Kind.RUN, text="ended"),
    )
    assert Record(again).visit_s(2) == (100.0, 102.0), "the state that has failed"
    assert Record(again).visit_s(3) == (104.0, 109.0), "left at the end of the record"
    assert Record(again[-1:]).visit_s(0) == (109.0, 109.0)


def test_another_state_has_no_feedback_yet():
    moment = RECORD.moment(4)
    assert moment.passed == ("/Locate", "/Insert")
    assert moment.feedback is None


def test_reasons_are_listed_with_the_latest_first():
    moment = RECORD.moment(7)
    assert [e.position for e in moment.reasons] == [8, 7]
    assert moment.picture == 7
    assert moment.feedback == RECORD.entries[5]


def test_a_failure_names_its_place():
    left = entry(1, 1.0, Kind.STATE, task="W1", state_path="")
    failed = entry(2, 1.0, Kind.FAILURE, task="W1", state_path="/Insert")
    decided = entry(3, 1.0, Kind.DECISION, task="W1", text="retry")
    record = Record((left, failed, decided))
    assert [record.moment(index).state_path for index in range(3)] == ["", "/Insert", "/Insert"]


def test_another_task_begins_with_nothing_passed():
    assert RECORD.moment(8).passed == ()
    assert RECORD.moment(9).passed == ("/Locate",)
    assert RECORD.moment(10).state_path == ""
    assert RECORD.moment(11).task == ""


@pytest.mark.parametrize(
    ("index", "step", "found"), [(0, 1, 6), (6, 1, 7), (7, 1, 7), (11, -1, 7), (6, -1, 6)]
)
def test_from_reason_to_reason(index, step, found):
    assert RECORD.next_reason(index, step) == found


def test_values_are_series_over_the_run():
    assert RECORD.value_names() == ("force_n", "completed_percentage")
    assert list(map(value_words, ("force_n", "completed_percentage", "gain_x", "n"))) == [
        "force [N]",
        "completed [%]",
        "gain x",
        "n",
    ]
    assert list(RECORD.series("force_n")) == [(4.0, 22.0)]


def test_lengths_are_shown_in_millimetres():
    record = Record((entry(1, 1.0, Kind.RESULT, values=(("depth_m", 0.0045),)),))
    assert value_words("depth_m") == "depth [mm]"
    assert list(record.series("depth_m")) == [(0.0, pytest.approx(4.5))]


def test_states_of_a_record_go_by_their_names_in_the_chart():
    def state(position, path):
        return entry(position, 1.0, Kind.STATE, task="W1", behavior="place", state_path=path)

    paths = ("/Place/Insert_attempts", "/Place/Insert", "/Place/Insert_error", "/Other")
    record = Record(tuple(state(i, path) for i, path in enumerate(paths, start=1)))
    named = in_chart_terms(record, lambda _: frozenset({"Place", "Place/Insert"}))
    assert [entry_words(e) for e in named.entries] == [
        "Place / Insert, before an attempt",
        "Place / Insert",
        "Place / Insert, after a failure",
        "Other",
    ]
    assert named.moment(0).state == "Place / Insert, before an attempt"
    unknown = in_chart_terms(record, lambda _: frozenset())
    assert unknown.moment(0).state == "Place / Insert_attempts"


def test_entries_are_read_from_messages(monkeypatch):
    message = RunEntry(position=1, kind="state", state_path="/A", names=["force_n"], values=[2.0])
    answer = GetRunResponse(success=True, entries=[message], total=1)
    monkeypatch.setattr(use_case_link, "call_service", lambda *args: answer)
    (found,) = use_case_link.RecordLink().record(7).entries
    assert found == entry(1, 0.0, Kind.STATE, state_path="/A", values=(("force_n", 2.0),))
