"""Supervise a state: apply commands, and carry out what supervision.py decides."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from flexbe_core.engine.events import NO_OUTCOME, Answered, Forced, Refused, Requested
from flexbe_core.engine.node import NOW
from flexbe_core.engine.supervision import (
    PENDING,
    Act,
    ActiveState,
    ForceOutcome,
    Moment,
    Pending,
    StateCommand,
    apply_command,
    decide,
)

if TYPE_CHECKING:
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.leaf import Leaf


def before(leaf: Leaf) -> tuple[Act, str | None]:
    """Decide what to do before execution.

    Returns:
        the act and, if the state is not to be executed but to leave, the outcome to leave with.
    """
    engine = leaf.engine
    _apply_commands(leaf)
    supervision = engine.supervision
    act = decide(supervision, _moment(leaf, PENDING, supervision.stored))
    if act is Act.RELEASE:
        engine.supervision = replace(supervision, stored=None)
        return act, supervision.stored
    if act is Act.FORCE:
        if engine.recording:
            engine.events.append(Forced(leaf.path, supervision.forced or "", supervision.requested))
        return act, supervision.forced
    if act is Act.WITHDRAW:
        _withdraw(leaf)
    return act, None


def after(leaf: Leaf, outcome: str | None) -> Act:
    """Decide whether the state may leave with `outcome`, and ask the operator if necessary."""
    engine = leaf.engine
    supervision = engine.supervision
    act = decide(supervision, _moment(leaf, outcome, outcome))
    if act is Act.STORE:
        engine.supervision = replace(supervision, stored=outcome, forced=None)
    elif act is Act.REPEAT:
        engine.supervision = replace(supervision, repeat=False)
    elif act is Act.WITHDRAW:
        _withdraw(leaf)
    elif act is Act.REQUEST and outcome is not None:
        engine.supervision = replace(supervision, requested=outcome)
        engine.events.append(Requested(leaf.path, leaf.definition._outcomes.index(outcome)))
    return act


def left(leaf: Leaf, outcome: str) -> None:
    """Note for mirrors that the state was left, and clear what applied only to this visit."""
    engine = leaf.engine
    if outcome in leaf.definition._outcomes:
        engine.leave(leaf, outcome)
    engine.supervision = engine.supervision.after_visit()


def exited(leaf: Leaf) -> None:
    """Clear what applied only to the visit that something else has ended."""
    engine = leaf.engine
    if engine.supervision.requested is not None:
        _withdraw(leaf)
    engine.supervision = engine.supervision.after_visit()


def at_breakpoint(leaf: Leaf, outcome: str | None) -> str | None:
    """Return the outcome with which a state leaves that is not supervised; None: it stays.

    Operators supervise only the first child of a concurrency container. A state of another child
    asks them at a breakpoint nevertheless, and is answered by its own name or path.
    """
    engine, ordered = leaf.engine, leaf.ordered
    is_stopped = (
        ordered is None
        and outcome in leaf.definition._outcomes
        and leaf.path in engine.supervision.breakpoints
    )
    if not is_stopped or outcome is None:
        forget_breakpoint(leaf)
        return outcome
    if outcome != leaf.requested:
        leaf.requested = outcome
        engine.stopped[leaf.path] = leaf
        engine.events.append(Requested(leaf.path, leaf.definition._outcomes.index(outcome)))
    return None


def forget_breakpoint(leaf: Leaf) -> None:
    """Withdraw what the operator was asked at a breakpoint, unless that was answered."""
    if leaf.requested is not None and leaf.ordered is None:
        leaf.engine.events.append(Requested(leaf.path, NO_OUTCOME))
    leaf.requested = leaf.ordered = None
    leaf.engine.stopped.pop(leaf.path, None)


def answer_at_breakpoint(engine: Engine, command: ForceOutcome) -> bool:
    """Take a forced outcome for a state that waits at a breakpoint; return whether it is for one.

    A name that the active supervised state has, too, means that state, as in stock FlexBE.
    """
    active = engine.root.leaf()
    named = [one for one in engine.stopped.values() if command.target in (one.path, one.label)]
    is_for_active = (
        active is not None and active.definition._is_controlled and command.target == active.label
    )
    if not named or is_for_active:
        return False
    outcomes = named[0].definition._outcomes
    if len(named) > 1:
        paths = ", ".join(repr(one.path) for one in named)
        text = f"several states named {command.target!r} wait at breakpoints; name one of {paths}"
        engine.events += [Answered("transition", (command.target, "")), Refused(text)]
    elif not 0 <= command.index < len(outcomes):
        declared = ", ".join(f"{index}: {name}" for index, name in enumerate(outcomes))
        text = f"asked for outcome {command.index} of {command.target!r}; it has {declared}"
        answer = Answered("transition", (command.target, command.target))
        engine.events += [answer, Refused(text)]
    else:
        named[0].ordered = outcomes[command.index]
        named[0].due = NOW
        engine.events.append(Answered("transition", (command.target, command.target)))
    return True


def _apply_commands(leaf: Leaf) -> None:
    """Apply the commands to the active state, up to a forced outcome.

    Commands after a forced outcome are for the next state.
    """
    engine = leaf.engine
    if not engine.commands:
        return
    name = leaf.definition._name or ""
    state = ActiveState(name, leaf.path, leaf.definition._outcomes, leaf.ancestors())
    while engine.commands and engine.supervision.forced is None:
        command: StateCommand = engine.commands.popleft()
        engine.supervision, events = apply_command(engine.supervision, command, state)
        engine.events.extend(events)
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
    locks = leaf.engine.supervision.locks
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
    engine.supervision = replace(engine.supervision, requested=None)
    engine.events.append(Requested(leaf.path, NO_OUTCOME))
