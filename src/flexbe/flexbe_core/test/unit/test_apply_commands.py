"""What each command to the active state changes, and how it is answered."""

import dataclasses

import pytest

from flexbe_core.engine.supervision import (
    ActiveState,
    Answered,
    ForceOutcome,
    Lock,
    Pause,
    Refused,
    Repeat,
    Resume,
    Supervision,
    Unlock,
    apply_command,
)

STATE = ActiveState("b", "/a/b", ["done", "failed"], ("/a", ""))
NOTHING = Supervision()
LOCKED = Supervision(locks=frozenset({"/a/b"}))

ACCEPTED = [
    # command, record before, changes, feedback
    (ForceOutcome("b", 1), NOTHING, {"forced": "failed"}, ("transition", ("b", "b"))),
    (ForceOutcome("/a/b", 1), NOTHING, {"forced": "failed"}, ("transition", ("/a/b", "/a/b"))),
    (Lock(""), NOTHING, {"locks": frozenset({"/a/b"})}, ("lock", ("/a/b", "/a/b"))),
    (Lock("/a/b"), NOTHING, {"locks": frozenset({"/a/b"})}, ("lock", ("/a/b", "/a/b"))),
    (Lock("/a"), NOTHING, {"locks": frozenset({"/a"})}, ("lock", ("/a", "/a"))),
    (Unlock(""), LOCKED, {"locks": frozenset()}, ("unlock", ("/a/b", "/a/b"))),
    (Unlock("/a/b"), LOCKED, {"locks": frozenset()}, ("unlock", ("/a/b", "/a/b"))),
    (Unlock("/a"), LOCKED, {}, ("unlock", ("/a", "/a"))),
    (Unlock(""), NOTHING, {}, ("unlock", ("", ""))),
    (Pause(), NOTHING, {"paused": True}, ("pause", ())),
    (Resume(), Supervision(paused=True), {"paused": False}, ("resume", ())),
    (Repeat(), NOTHING, {"repeat": True}, ("repeat", ())),
]


@pytest.mark.parametrize(("command", "before", "changes", "feedback"), ACCEPTED, ids=str)
def test_a_command_is_applied_and_answered(command, before, changes, feedback):
    after, events = apply_command(before, command, STATE)
    assert after == dataclasses.replace(before, **changes)
    assert events == (Answered(*feedback),)


REFUSED = [
    (ForceOutcome("other", 0), ("transition", ("other", "b")), "'b' is active"),
    (ForceOutcome("b", 2), ("transition", ("b", "b")), "0: done, 1: failed"),
    (Lock("/a/other"), ("lock", ("/a/other", "")), "active is '/a/b'"),
    (Unlock("/other"), ("unlock", ("/other", "")), "active is '/a/b'"),
]


@pytest.mark.parametrize(("command", "feedback", "reason"), REFUSED, ids=str)
def test_a_senseless_command_changes_nothing_and_is_explained(command, feedback, reason):
    after, (answer, refusal) = apply_command(NOTHING, command, STATE)
    assert after == NOTHING
    assert answer == Answered(*feedback)
    assert isinstance(refusal, Refused)
    assert reason in refusal.text


def test_lock_then_unlock_is_identity():
    locked, _ = apply_command(NOTHING, Lock(""), STATE)
    assert apply_command(locked, Unlock(""), STATE)[0] == NOTHING
