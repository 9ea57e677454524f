"""A state that an operator can stop."""

from __future__ import annotations

from typing import ClassVar

from flexbe_core.core.lockable_state import LockableState
from flexbe_core.engine.supervision import PREEMPTED


class PreemptableState(LockableState):
    """A state that an operator can stop.

    Attributes:
        preempt: True stops whatever is executed by hand in this process (stock FlexBE's flag).
            Constructing a state sets it back. Behaviors are stopped one by one: Behavior.preempt.
    """

    preempt: ClassVar[bool] = False
    _preempted_name: ClassVar[str] = PREEMPTED

    def __init__(self, *args: object, **kwargs: object) -> None:
        super().__init__(*args, **kwargs)
        PreemptableState.preempt = False
