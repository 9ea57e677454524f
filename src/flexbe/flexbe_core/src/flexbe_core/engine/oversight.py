"""Carry out what decision.decide decides about a supervised state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from flexbe_core.engine.commands import StateCommand
from flexbe_core.engine.decision import PENDING, Act, Moment, Pending, decide
from flexbe_core.engine.facts import NO_OUTCOME, Forced, Requested
from flexbe_core.engine.obey import ActiveState, obey

if TYPE_CHECKING:
    from flexbe_core.engine.leaf import Leaf


def before(leaf: Leaf) -> tuple[Act, str | None]:
    """Decide what to do before execution.

    Returns:
        the act and, if the state is not to be executed but to leave, the outcome to leave with.
    """
    engine = leaf.engine
    _obey_commands(leaf)
    record = engine.record
    act = decide(record, _moment(leaf, PENDING, record.stored))
    if act is Act.RELEASE:
        engine.record = replace(record, stored=None)
        return act, record.stored
    if act is Act.FORCE:
        if engine.recording:
            engine.facts.append(Forced(leaf.path, record.forced or "", record.requested))
        return act, record.forced
    if act is Act.WITHDRAW:
        _withdraw(leaf)
    return act, None


def after(leaf: Leaf, outcome: str | None) -> Act:
    """Decide whether the state may leave with `outcome`, and tell the operator."""
    engine = leaf.engine
    record = engine.record
    act = decide(record, _moment(leaf, outcome, outcome))
    if act is Act.STORE:
        engine.record = replace(record, stored=outcome, forced=None)
    elif act is Act.REPEAT:
        engine.record = replace(record, repeat=False)
    elif act is Act.WITHDRAW:
        _withdraw(leaf)
    elif act is Act.REQUEST and outcome is not None:
        engine.record = replace(record, requested=outcome)
        engine.facts.append(Requested(leaf.path, leaf.definition._outcomes.index(outcome)))
    return act


def left(leaf: Leaf, outcome: str) -> None:
    """Note for mirrors that the state was left, and drop what concerned only this visit."""
    engine = leaf.engine
    if outcome in leaf.definition._outcomes:
        engine.leave(leaf, outcome)
    engine.record = engine.record.after_visit()


def _obey_commands(leaf: Leaf) -> None:
    """Obey what the operator asked of the active state, up to an outcome that he forces.

    What comes behind a forced outcome is meant for the next state.
    """
    engine = leaf.engine
    if not engine.commands:
        return
    name = leaf.definition._name or ""
    state = ActiveState(name, leaf.path, leaf.definition._outcomes, leaf.ancestors())
    while engine.commands and engine.record.forced is None:
        command: StateCommand = engine.commands.popleft()
        engine.record, facts = obey(engine.record, command, state)
        engine.facts.extend(facts)
    engine.claim_while_paused(leaf.path)


def _moment(leaf: Leaf, outcome: str | Pending | None, leaving_with: str | None) -> Moment:
    return Moment(
        path=leaf.path,
        supervised=True,
        outcome=outcome,
        required_autonomy=-1 if leaving_with is None else _required_autonomy(leaf, leaving_with),
        leaves_locked=leaving_with is not None and _leaves_locked(leaf, leaving_with),
    )


def _required_autonomy(leaf: Leaf, outcome: str) -> int:
    if leaf.parent is None:
        return -1
    levels: Mapping[str, int] = leaf.parent.definition._autonomy.get(leaf.label, {})
    return levels.get(outcome, -1)


def _leaves_locked(leaf: Leaf, outcome: str) -> bool:
    """Return whether a locked container around the state would be left with this outcome."""
    locks = leaf.engine.record.locks
    target: str | None = leaf.targets.get(outcome)
    container = leaf.parent
    while locks and container is not None and target is not None:
        if target in container.definition._labels:
            return False
        if container.path in locks:
            return True
        target = container.targets.get(target)
        container = container.parent
    return False


def _withdraw(leaf: Leaf) -> None:
    engine = leaf.engine
    engine.record = replace(engine.record, requested=None)
    engine.facts.append(Requested(leaf.path, NO_OUTCOME))
