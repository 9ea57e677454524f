"""What the console knows of a run, whatever the order of topics; no ROS."""

from functools import reduce

import pytest

from remodel_console.core.run_view import (
    Acknowledged,
    Asked,
    EngineSeen,
    EngineStatus,
    Entered,
    Left,
    LevelSeen,
    Ordered,
    Phase,
    RunView,
    Troubled,
    state_words,
    step,
)
from remodel_console.core.running import Level, Structure, chart_state

READY, STARTED = EngineStatus(20, 0), EngineStatus(0, 7)
TREE = Structure(
    7,
    (
        Level("", ("A", "Box"), ("finished",), ()),
        Level("/A", (), ("done",), ("Box",)),
        Level("/Box", ("In", "Out"), ("found",), ("finished",)),
        Level("/Box/In", (), ("done", "again"), ("Out", "In")),
        Level("/Box/Out", (), ("done",), ("found",)),
    ),
)


def after(*events):
    return reduce(step, events, RunView())


def supervised(*events):
    return after(READY, Ordered(1, 7), STARTED, TREE, Entered("/A"), Left("/A", "done"), *events)


def test_a_run_from_ready_to_its_end():
    view = after(READY, STARTED, Entered("/A"))
    assert (view.phase, view.active, view.is_supervised) == (Phase.RUNNING, "/A", False)
    view = step(view, EngineStatus(1, 7, ("finished",)))
    assert (view.phase, view.active, view.ending) == (Phase.IDLE, "", "ended with 'finished'")


def test_a_start_says_what_it_waits_for_until_it_has_begun_or_is_refused():
    start, waits = Ordered(1, 7), "waiting up to 10 s for action server insert"
    view = after(READY, start)
    assert state_words(view, waits=False) == "starting"
    view = step(view, Troubled(waits))
    assert state_words(view, waits=False) == f"starting: {waits}"
    assert state_words(step(view, STARTED), waits=False) == "running"
    refused = step(view, EngineStatus(11, 7))
    assert (state_words(refused, waits=False), refused.has_failed) == ("idle", True)
    assert not step(view, Ordered(None)).is_starting, "it could not be sent"
    assert not step(view, EngineSeen(False)).is_starting
    assert not step(after(READY, start, STARTED), start).is_starting, "a switch"


def test_a_state_that_arrives_before_the_start_of_its_run_counts():
    assert after(READY, Entered("/A"), STARTED).active == "/A"
    assert (
        after(READY, STARTED, Entered("/A"), Entered(""), EngineStatus(1, 7), STARTED).active == ""
    )


def test_what_the_engine_publishes_counts_more_than_the_mirror():
    view = supervised(Left("/Box/In", "done"), Entered("/Box/In"))
    assert view.active == "/Box/Out"
    assert view.visited == {"/A", "/Box/In", "/Box/Out"}


def test_a_structure_that_comes_late_is_enough():
    view = after(READY, Ordered(1, 7), STARTED, Left("/A", "done"), TREE, Entered("/A"))
    assert view.active == "/Box/In"
    assert step(view, Left("/Box/Out", "done")).visited == {"/A", "/Box/In", "/Box/Out"}


def test_a_request_stays_until_it_is_answered_withdrawn_or_passed():
    asked = supervised(Asked("/Box/Out", 0), Left("/Box/In", "done"), Entered("/Box/In"))
    assert asked.asked == Asked("/Box/Out", 0)
    assert asked.active == "/Box/Out"
    assert step(asked, Asked("/Box/Out", 255)).asked is None
    assert step(asked, Left("/Box/Out", "done")).asked is None
    assert step(asked, Acknowledged("transition", ("Out", "Out"))).asked is None
    assert step(asked, Acknowledged("transition", ("Out", "In"))).asked == asked.asked


def test_attaching_counts_once_the_engine_says_so():
    view = after(READY, STARTED, Ordered(2))
    assert not view.is_supervised
    view = step(view, Acknowledged("attach", ("Errand",)))
    assert (view.is_supervised, view.level, view.attached_name) == (True, 2, "Errand")


def test_levels_of_a_start_count_for_that_behavior_only():
    assert after(READY, Ordered(1, 7), STARTED).is_supervised
    assert not after(READY, Ordered(1, 8), STARTED).is_supervised
    assert not after(READY, Ordered(255, 7), STARTED).is_supervised


@pytest.mark.parametrize(
    ("command", "args", "held"),
    [
        ("lock", ("/A", "/A"), "/A"),
        ("lock", ("/A", ""), None),
        ("unlock", ("/A", "/A"), None),
    ],
)
def test_locks(command, args, held):
    assert supervised(Acknowledged(command, args)).held == held


def test_pause_and_resume():
    paused = supervised(Acknowledged("pause"))
    assert paused.is_paused
    assert not step(paused, Acknowledged("resume")).is_paused


def test_an_engine_that_goes_away_leaves_no_ghost():
    view = supervised(EngineSeen(False))
    assert (view.phase, view.active, view.asked) == (Phase.AWAY, "", None)
    assert view.ending == "was cut off when the engine ended"
    assert step(view, EngineSeen(True)).phase is Phase.IDLE


def test_a_refused_switch_ends_nothing():
    view = supervised(EngineStatus(11, 9))
    assert view.phase is Phase.RUNNING
    assert view.is_ending_bad


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (("preempted",), 1, "was stopped"),
        ((), 2, "failed; the log says why"),
        ((), 11, "was not started; the log says why"),
    ],
)
def test_endings(args, code, words):
    assert after(READY, EngineStatus(code, 7, args)).ending == words


@pytest.mark.parametrize(
    ("path", "outcome", "following"),
    [
        ("/A", "done", "/Box/In"),
        ("/Box/In", "again", "/Box/In"),
        ("/Box/Out", "done", ""),
        ("/Box/Out", "never", None),
        ("/Other", "done", None),
    ],
)
def test_what_follows_an_outcome(path, outcome, following):
    assert TREE.following(path, outcome) == following


def test_levels_that_can_be_locked():
    assert supervised().holdable() == ("/Box/In", "/Box")


def test_a_run_that_was_supervised_before_the_console_knew_it_is_supervised():
    for events in ((STARTED, LevelSeen(1)), (LevelSeen(1), STARTED)):
        view = after(READY, *events)
        assert (view.is_supervised, view.level) == (True, 1)
    assert not after(READY, STARTED, LevelSeen(255)).is_supervised
    assert not after(READY, STARTED, LevelSeen(1), EngineStatus(1, 7), STARTED).is_supervised


def test_a_request_that_overtakes_the_answer_to_the_one_before_stays():
    view = supervised(Asked("/Box/Out", 0), Acknowledged("transition", ("In", "In")))
    assert view.asked == Asked("/Box/Out", 0)
    assert step(view, Acknowledged("transition", ("Out", "Out"))).asked is None


def test_states_beside_each_other_ask_at_breakpoints_and_none_is_forgotten():
    view = supervised(Asked("/Box/In", 0), Asked("/Box/Out", 0))
    assert (view.asked, view.active) == (Asked("/Box/Out", 0), "/Box/Out")
    view = step(view, Acknowledged("transition", ("Out", "Out")))
    assert (view.asked, view.active) == (Asked("/Box/In", 0), "/Box/In")
    assert step(view, Acknowledged("transition", ("In", "In"))).asked is None


def test_after_a_breakpoint_beside_it_the_state_that_goes_on_is_active_again():
    for end in (Acknowledged("transition", ("Out", "Out")), Asked("/Box/Out", 255)):
        view = supervised(Asked("/Box/Out", 0), end)
        assert (view.asked, view.active) == (None, "/Box/In")


HELPED = Structure(
    7,
    (
        Level(
            "", ("Insert_attempts", "Insert", "Insert_error", "Look", "log_error"), ("failed",), ()
        ),
        Level("/Insert_attempts", (), ("counted", "exhausted"), ("Insert", "failed")),
        Level("/Insert", (), ("done", "failed"), ("failed", "Insert_error")),
        Level("/Insert_error", (), ("jammed", "other"), ("failed", "failed")),
        Level("/log_error", (), ("done",), ("failed",)),
        Level("/Look", ("run", "timer"), ("done", "timed_out"), ("failed", "failed")),
        Level("/Look/run", ("In",), ("done",), ("done",)),
        Level("/Look/run/In", (), ("done",), ("done",)),
        Level("/Look/timer", (), ("done",), ("timed_out",)),
    ),
)


@pytest.mark.parametrize(
    ("path", "outcome", "words", "event"),
    [
        ("/Insert", "done", "Insert", "done"),
        ("/Insert_attempts", "counted", "Insert, before an attempt", ""),
        ("/Insert_attempts", "exhausted", "Insert, before an attempt", "exhausted"),
        ("/Insert_error", "other", "Insert, after a failure", "failed"),
        ("/Insert_error", "jammed", "Insert, after a failure", "jammed"),
        ("/Look/run/In", "done", "Look / In", "done"),
        ("/Look/timer", "done", "Look, its time limit", "timed_out"),
        ("/log_error", "done", "log_error", "done"),
    ],
)
def test_what_synthesis_added_is_named_by_the_state_of_the_chart(path, outcome, words, event):
    state = chart_state(path, HELPED)
    assert (state.words, state.event(outcome)) == (words, event)
    asked = f"Leave '{state.label}' with '{event}'?" if event else f"Enter '{state.label}'?"
    assert state.question(outcome) == asked
    assert state.answer(outcome) == (event or f"enter {state.label}")


def failing(*events):
    return after(READY, Ordered(1, 7), STARTED, HELPED, *events, EngineStatus(1, 7, ("failed",)))


def test_a_run_that_failed_says_what_failed_in_it_and_what_the_log_says():
    view = failing(Left("/Insert", "failed"), Left("/Insert_error", "other"))
    assert view.has_failed
    assert view.ending_words == (
        "ended with 'failed': 'Insert' was left with 'failed'; the log says why"
    )
    late = step(view, Troubled("InsertCable failed: error 303: 22 N"))
    assert late.ending_words == (
        "ended with 'failed': 'Insert' was left with 'failed'; "
        "the log says: InsertCable failed: error 303: 22 N"
    )
    assert step(late, Troubled("something else")) == late, "what comes later is no cause"
    assert "exhausted" in failing(Left("/Insert_attempts", "exhausted")).ending_words
    inner = failing(Left("/Look/run/In", "failed"), Left("/Look", "failed"))
    assert "'In' was left with 'failed'" in inner.ending_words
    outer = failing(Left("/Look/run/In", "done"), Left("/Look", "timed_out"))
    assert "'Look' was left with 'timed_out'" in outer.ending_words


def test_a_run_that_did_not_fail_needs_no_cause():
    events = (
        Troubled("a try failed"),
        Left("/Insert", "failed"),
        EngineStatus(1, 7, ("finished",)),
    )
    view = after(READY, STARTED, *events)
    assert (view.ending_words, view.has_failed) == ("ended with 'finished'", False)
    refused = step(view, EngineStatus(11, 7))
    assert refused.ending_words == "was not started; the log says why"
    assert after(READY, STARTED, *events, STARTED).trouble == ""
