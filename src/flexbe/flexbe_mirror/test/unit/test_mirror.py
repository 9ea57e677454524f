"""How a mirror responds to the messages of an engine."""

import pytest
from flexbe_msgs.msg import Container

from flexbe_core.engine.supervision import StatusCode, checksum
from flexbe_mirror.flexbe_mirror import (
    ASK_AFTER_S,
    ASK_AGAIN_S,
    SILENCE_S,
    AskForStructure,
    AskWhere,
    Mirror,
    Show,
    Tree,
)

TREE = Tree(
    [
        Container(path="", children=["A", "B"]),
        Container(path="/A", outcomes=["done"], transitions=["B"]),
        Container(path="/B", outcomes=["done", "end"], transitions=["A", "finished"]),
    ]
)
BEHAVIOR = 7


def status(mirror, code, behavior_id=BEHAVIOR, args=(), now=0.0):
    return mirror.on_status(code.value, behavior_id, args, now)


def following():
    mirror = Mirror()
    mirror.on_structure(BEHAVIOR, TREE)
    assert status(mirror, StatusCode.STARTED) == [Show("/A")]
    return mirror


def test_a_behavior_whose_structure_came_before_is_followed_at_once():
    mirror = following()
    assert mirror.on_outcome(0) == [Show("/B")]
    assert mirror.on_outcome(0) == [Show("/A")]
    mirror.on_outcome(0)
    assert mirror.on_outcome(1) == [], "a status reports the end"
    assert status(mirror, StatusCode.FINISHED) == [Show("")]


def test_a_structure_that_comes_after_the_start_leaves_the_active_state_unknown():
    mirror = Mirror()
    assert status(mirror, StatusCode.STARTED) == []
    assert mirror.on_outcome(0) == [], "only the structure says of which state"
    assert mirror.on_structure(BEHAVIOR, TREE) == [AskWhere()]
    assert mirror.on_sync(BEHAVIOR, checksum("/B")) == [Show("/B")]


def test_a_structure_that_does_not_come_is_asked_for_and_then_where_the_behavior_is():
    mirror = Mirror()
    assert status(mirror, StatusCode.STARTED, now=10.0) == []
    assert mirror.on_time(10.0 + 0.9 * ASK_AFTER_S) == []
    asked = 10.0 + ASK_AFTER_S
    assert mirror.on_time(asked) == [AskForStructure(BEHAVIOR)]
    assert mirror.on_time(asked + 0.9 * ASK_AGAIN_S) == []
    assert mirror.on_time(asked + ASK_AGAIN_S) == [AskForStructure(BEHAVIOR)]
    assert mirror.on_structure(99, TREE) == [], "that of another behavior"
    assert mirror.on_structure(BEHAVIOR, TREE) == [AskWhere()]
    assert mirror.on_outcome(0) == [], "of which state is not known yet"
    assert mirror.on_sync(BEHAVIOR, checksum("/B")) == [Show("/B")]
    assert mirror.on_outcome(0) == [Show("/A")]


def test_each_run_requests_its_structure_so_that_the_engine_publishes_outcomes():
    mirror = following()
    status(mirror, StatusCode.FINISHED)
    assert status(mirror, StatusCode.STARTED, now=10.0) == []
    assert mirror.on_time(10.0 + ASK_AFTER_S) == [AskForStructure(BEHAVIOR)]


def test_a_switched_behavior_is_followed_from_the_state_that_goes_on():
    mirror = following()
    mirror.on_structure(8, TREE)
    assert status(mirror, StatusCode.SWITCHING) == [Show("")]
    assert status(mirror, StatusCode.STARTED, 8, ("/B",)) == [Show("/B")]


@pytest.mark.parametrize(
    "code", [StatusCode.FINISHED, StatusCode.FAILED, StatusCode.ERROR, StatusCode.READY]
)
def test_every_end_shows_that_nothing_runs_once(code):
    mirror = following()
    assert status(mirror, code) == [Show("")]
    assert status(mirror, code) == []


def test_a_new_mirror_shows_that_nothing_runs():
    mirror = Mirror()
    assert status(mirror, StatusCode.READY) == [Show("")]
    assert status(mirror, StatusCode.FINISHED) == []


def test_a_refused_start_of_another_behavior_changes_nothing():
    mirror = following()
    assert status(mirror, StatusCode.ERROR, behavior_id=99) == []
    assert mirror.path == "/A"


def test_an_impossible_outcome_makes_it_ask_where_the_behavior_is():
    mirror = following()
    assert mirror.on_outcome(5) == [AskWhere()]
    assert mirror.path == "/A"


def test_a_state_that_the_structure_lacks_makes_it_ask_too():
    mirror = following()
    mirror.on_active_state("/Other")
    assert mirror.on_outcome(0) == [AskWhere()]


def test_syncs_of_another_behavior_or_an_unknown_state_change_nothing():
    mirror = following()
    assert mirror.on_sync(99, checksum("/B")) == []
    assert mirror.on_sync(BEHAVIOR, 5) == []


def test_an_engine_that_names_its_active_state_is_shown_as_it_says():
    mirror = following()
    assert mirror.on_active_state("/A") == [], "it is shown since the start"
    assert mirror.on_active_state("/B") == [Show("/B")]
    assert mirror.on_active_state("/B") == [Show("/B")], "it follows itself"
    assert mirror.on_active_state("") == [], "a status reports the end"
    assert status(mirror, StatusCode.FINISHED) == [Show("")]


def test_an_active_state_that_comes_before_the_start_is_shown_with_it():
    mirror = Mirror()
    assert mirror.on_active_state("/B") == []
    assert status(mirror, StatusCode.STARTED) == [Show("/B")]
    status(mirror, StatusCode.FINISHED)
    assert status(mirror, StatusCode.STARTED) == [], "that of the run before is not shown again"


def test_an_engine_that_falls_silent_is_followed_again_when_it_is_heard():
    mirror = following()
    assert mirror.on_time(SILENCE_S + 0.1) == [Show("")]
    assert mirror.on_time(SILENCE_S + 1) == []
    assert mirror.on_heartbeat(20.0) == []
    assert mirror.on_time(20.0 + ASK_AFTER_S) == [AskForStructure(BEHAVIOR)]
    assert mirror.on_structure(BEHAVIOR, TREE) == [AskWhere()]
    assert mirror.on_sync(BEHAVIOR, checksum("/B")) == [Show("/B")]
