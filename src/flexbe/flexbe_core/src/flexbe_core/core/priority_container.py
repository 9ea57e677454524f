"""A container that pauses what runs beside it."""

from __future__ import annotations

from typing import ClassVar

from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.engine.definition import Kind


class PriorityContainer(OperatableStateMachine):
    """A state machine that runs alone: while it is active, states beside it are paused."""

    __kind__: ClassVar[Kind] = Kind.PRIORITY
