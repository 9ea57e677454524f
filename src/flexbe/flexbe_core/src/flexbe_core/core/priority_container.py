"""A container that pauses what runs beside it."""

from __future__ import annotations

from typing import ClassVar

from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.engine.definitions import Kind
from flexbe_core.ros.session import Session


class _Priority(type):
    """Provides stock FlexBE's attribute of the class; each run has a priority of its own."""

    @property
    def active_container(cls) -> str | None:
        """Path of the priority container that is active in what was last executed by hand.

        An assigned path applies to what is executed by hand next.
        """
        return Session.priority_by_hand

    @active_container.setter
    def active_container(cls, path: str | None) -> None:
        Session.assign_priority(path)


class PriorityContainer(OperatableStateMachine, metaclass=_Priority):
    """A state machine that runs alone: while it is active, states beside it are paused."""

    __kind__: ClassVar[Kind] = Kind.PRIORITY
