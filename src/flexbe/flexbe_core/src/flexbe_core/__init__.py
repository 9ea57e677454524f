"""FlexBE's Python API: what behaviors and states import."""

from flexbe_core.behavior import Autonomy, Behavior
from flexbe_core.behavior_library import BehaviorLibrary
from flexbe_core.core import (
    ConcurrencyContainer,
    EventState,
    OperatableStateMachine,
    PriorityContainer,
)
from flexbe_core.logger import Logger
from flexbe_core.ros.driver import wake_at
from flexbe_core.state_logger import StateLogger

__all__ = [
    "Autonomy",
    "Behavior",
    "BehaviorLibrary",
    "ConcurrencyContainer",
    "EventState",
    "Logger",
    "OperatableStateMachine",
    "PriorityContainer",
    "StateLogger",
    "wake_at",
]
