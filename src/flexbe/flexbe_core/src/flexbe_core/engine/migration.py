"""Migrate the active state of a run to another version of the behavior.

The old run detaches its active state without exiting it, and ends. The new run begins at that
state: its containers begin with the runtime userdata of the old ones, and the state continues,
locked until an operator unlocks it. Other active states are exited, and begin again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexbe_core.engine.containers import Container
from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.user_data import UserData

if TYPE_CHECKING:
    from flexbe_core.engine.definitions import Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.user_data import Value


@dataclass(frozen=True)
class MigratingState:
    """The active state of a run, to be attached to another version.

    Attributes:
        path: its path.
        state: the state itself, with its attributes.
        entered: whether its visit has begun.
        userdata: runtime userdata of the containers around it, by their paths.
        paused: whether the run is paused; the new run is then paused too, if it is supervised.
        is_new: no other version has run: the run begins at this state, not locked.
    """

    path: str
    state: Definition
    entered: bool
    userdata: Mapping[str, Mapping[str, Value]]
    paused: bool = False
    is_new: bool = False


def migrating_state(engine: Engine) -> MigratingState | None:
    """Return the state to migrate; None if none is active, or the root itself is a state."""
    leaf = engine.root.leaf()
    if leaf is None or leaf.parent is None:
        return None
    userdata = {}
    container: Container | None = leaf.parent
    while container is not None:
        userdata[container.path] = dict(container.userdata._data)
        container = container.parent
    return MigratingState(
        path=leaf.path,
        state=leaf.definition,
        entered=leaf.entered,
        userdata=userdata,
        paused=engine.supervision.paused,
    )


def detach_state(engine: Engine) -> None:
    """End the run without its active state; to be called once another version has attached it."""
    leaf = engine.root.leaf()
    if leaf is not None:
        leaf.entered = False
    engine.released = True
    engine.supervision = replace(engine.supervision, preempt=True)


def attach_state(engine: Engine, migrating: MigratingState) -> None:
    """Begin a run at a state of another version, which is in its definition already."""
    node = engine.root
    for label in migrating.path.split("/")[1:]:
        if not isinstance(node, Container):
            raise TypeError(f"{node.path!r} is not a container; there is no {migrating.path!r}")
        node.begin(UserData() if node is engine.root else None)
        node.userdata._data.update(migrating.userdata.get(node.path, {}))
        node = node.resume(label)
    if not isinstance(node, Leaf):
        raise TypeError(f"{node.path!r} is not a state")
    node.resume_visit(migrating.entered)
    supervision, paused = engine.supervision, migrating.paused and node.definition._is_controlled
    locks = supervision.locks if migrating.is_new else supervision.locks | {node.path}
    engine.supervision = replace(supervision, locks=locks, paused=paused)
    engine.claim_while_paused(node.path)
