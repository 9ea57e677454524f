"""Hand the active state of a run over to another version of the behavior.

The old run lets go of its active state without exiting it, and ends. The new run begins there: the
containers on the way begin with the runtime userdata of the old ones, and the state goes on, locked
until an operator unlocks it. What else is active beside it is exited, and begins anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexbe_core.engine.container import Container
from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.user_data import UserData

if TYPE_CHECKING:
    from flexbe_core.engine.definition import Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.fingerprint import Value


@dataclass(frozen=True)
class Handover:
    """The active state of a run.

    Attributes:
        path: its path.
        state: the state itself, with whatever it keeps.
        entered: whether its visit has begun.
        userdata: runtime userdata of the containers around it, by their paths.
        paused: whether the run is paused; it then goes on paused, if it is supervised.
    """

    path: str
    state: Definition
    entered: bool
    userdata: Mapping[str, Mapping[str, Value]]
    paused: bool = False


def active_state(engine: Engine) -> Handover | None:
    """Return what can be handed over now; None if no state is active, or the run is one state."""
    leaf = engine.root.leaf()
    if leaf is None or leaf.parent is None:
        return None
    userdata = {}
    container: Container | None = leaf.parent
    while container is not None:
        userdata[container.path] = dict(container.userdata._data)
        container = container.parent
    return Handover(leaf.path, leaf.definition, leaf.entered, userdata, engine.record.paused)


def let_go(engine: Engine) -> None:
    """End the run as if its active state were not there; call it once that has been taken over."""
    leaf = engine.root.leaf()
    if leaf is not None:
        leaf.entered = False
    engine.released = True
    engine.record = replace(engine.record, preempt=True)


def take_over(engine: Engine, handover: Handover) -> None:
    """Begin a run at a state that was handed over, and that is in place in its definition."""
    node = engine.root
    for label in handover.path.split("/")[1:]:
        if not isinstance(node, Container):
            raise TypeError(f"{node.path!r} is no container; there is no {handover.path!r}")
        node.begin(UserData() if node is engine.root else None)
        node.userdata._data.update(handover.userdata.get(node.path, {}))
        node = node.resume(label)
    if not isinstance(node, Leaf):
        raise TypeError(f"{node.path!r} is no state")
    node.go_on(handover.entered)
    record, paused = engine.record, handover.paused and node.definition._is_controlled
    engine.record = replace(record, locks=record.locks | {node.path}, paused=paused)
    engine.claim_while_paused(node.path)
