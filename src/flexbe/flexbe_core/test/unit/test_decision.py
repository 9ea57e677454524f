"""The precedence of supervision, row by row, and between neighbouring rows."""

import dataclasses
import itertools

import pytest

from flexbe_core.engine.supervision import AFTER, BEFORE, PENDING, Act, Moment, Supervision, decide

HERE = frozenset({"/a"})
NOTHING = Supervision(autonomy_level=3)
WAITING = Moment("/a", supervised=True)
DONE = Moment("/a", supervised=True, outcome="done", required_autonomy=0)
NOT_DONE = Moment("/a", supervised=True, outcome=None)


def given(**changes):
    return dataclasses.replace(NOTHING, **changes)


def moment(base, **changes):
    return dataclasses.replace(base, **changes)


ROWS = [
    # name of the rule, supervision, moment, act
    ("preempted", given(preempt=True), WAITING, Act.PREEMPT),
    ("shadowed", NOTHING, moment(WAITING, supervised=False, shadowed=True), Act.SKIP),
    ("paused", given(paused=True), WAITING, Act.SKIP),
    (
        "locked, no longer asking",
        given(stored="done", locks=HERE, requested="done"),
        WAITING,
        Act.WITHDRAW,
    ),
    ("locked with an outcome", given(stored="done", locks=HERE), WAITING, Act.STAY),
    ("unlocked with an outcome", given(stored="done"), WAITING, Act.RELEASE),
    ("forced", given(forced="done"), WAITING, Act.FORCE),
    ("free to run", NOTHING, WAITING, Act.EXECUTE),
    ("preempted itself", NOTHING, moment(DONE, outcome="preempted"), Act.LEAVE),
    ("locked", given(locks=HERE), DONE, Act.STORE),
    ("repeated", given(repeat=True), NOT_DONE, Act.REPEAT),
    ("changed its mind", given(requested="done"), NOT_DONE, Act.WITHDRAW),
    ("not done", NOTHING, NOT_DONE, Act.STAY),
    ("asked already", given(autonomy_level=0, requested="done"), DONE, Act.STAY),
    ("needs consent", given(autonomy_level=0), DONE, Act.REQUEST),
    ("done", NOTHING, DONE, Act.LEAVE),
]


def test_every_rule_has_a_row_here():
    assert [rule.name for rule in BEFORE + AFTER] == [row[0] for row in ROWS]


@pytest.mark.parametrize(("name", "in_force", "now", "act"), ROWS, ids=[row[0] for row in ROWS])
def test_each_rule_decides_its_row(name, in_force, now, act):
    rules = BEFORE if now.outcome is PENDING else AFTER
    first = next(rule for rule in rules if rule.applies(in_force, now))
    assert first.name == name
    assert decide(in_force, now) is act


PRECEDENCE = [
    # (stronger, weaker): both are in force
    ("preempt wins over pause", given(preempt=True, paused=True), WAITING, Act.PREEMPT),
    (
        "preempt wins over the shadow of a priority container",
        given(preempt=True),
        moment(WAITING, shadowed=True),
        Act.PREEMPT,
    ),
    (
        "preempt wins over a lock",
        given(preempt=True, stored="done", locks=HERE),
        WAITING,
        Act.PREEMPT,
    ),
    ("pause wins over a forced outcome", given(paused=True, forced="done"), WAITING, Act.SKIP),
    ("pause wins over an unlocked outcome", given(paused=True, stored="done"), WAITING, Act.SKIP),
    (
        "a lock wins over a forced outcome before execution",
        given(stored="done", forced="done", locks=HERE),
        WAITING,
        Act.STAY,
    ),
    (
        "a lock wins over a forced outcome after execution",
        given(forced="done", locks=HERE),
        DONE,
        Act.STORE,
    ),
    (
        "a lock of a container around it counts as much",
        NOTHING,
        moment(DONE, leaves_locked=True),
        Act.STORE,
    ),
    ("a lock wins over missing autonomy", given(autonomy_level=0, locks=HERE), DONE, Act.STORE),
    ("a forced outcome needs no autonomy", given(autonomy_level=0, forced="done"), DONE, Act.LEAVE),
    (
        "a forced outcome passes a breakpoint",
        given(breakpoints=HERE, forced="done"),
        DONE,
        Act.LEAVE,
    ),
    (
        "a breakpoint asks whatever the level",
        given(autonomy_level=255, breakpoints=HERE),
        DONE,
        Act.REQUEST,
    ),
    ("a repeat wins over asking", given(autonomy_level=0, repeat=True), DONE, Act.REPEAT),
    ("an outcome that may leave wins over a repeat", given(repeat=True), DONE, Act.LEAVE),
    (
        "another outcome is requested again",
        given(autonomy_level=0, requested="other"),
        DONE,
        Act.REQUEST,
    ),
    (
        "a level is too low for a transition that needs it",
        given(autonomy_level=2),
        moment(DONE, required_autonomy=2),
        Act.REQUEST,
    ),
    (
        "a level is enough for a transition that needs less",
        given(autonomy_level=2),
        moment(DONE, required_autonomy=1),
        Act.LEAVE,
    ),
    (
        "level 0 blocks even Off",
        given(autonomy_level=0),
        moment(DONE, required_autonomy=0),
        Act.REQUEST,
    ),
    (
        "level 255 blocks nothing",
        given(autonomy_level=255),
        moment(DONE, required_autonomy=3),
        Act.LEAVE,
    ),
    (
        "an outcome without a level needs no consent",
        given(autonomy_level=0),
        moment(DONE, required_autonomy=-1),
        Act.LEAVE,
    ),
]


@pytest.mark.parametrize(
    ("in_force", "now", "act"), [row[1:] for row in PRECEDENCE], ids=[row[0] for row in PRECEDENCE]
)
def test_the_stronger_rule_wins(in_force, now, act):
    assert decide(in_force, now) is act


def test_an_unsupervised_state_is_only_preempted_or_shadowed():
    choices = {
        "autonomy_level": (0, 255),
        "paused": (False, True),
        "locks": (frozenset(), HERE),
        "breakpoints": (frozenset(), HERE),
        "forced": (None, "done"),
        "repeat": (False, True),
        "stored": (None, "done"),
        "requested": (None, "done"),
    }
    for chosen in itertools.product(*choices.values()):
        in_force = given(**dict(zip(choices, chosen, strict=True)))
        for outcome, act in ((PENDING, Act.EXECUTE), (None, Act.STAY), ("done", Act.LEAVE)):
            now = Moment("/a", supervised=False, outcome=outcome)
            assert decide(in_force, now) is act, in_force
