"""The classes that users derive from, at their stock import paths."""

from flexbe_core.core.concurrency_container import ConcurrencyContainer
from flexbe_core.core.event_state import EventState
from flexbe_core.core.lockable_state import LockableState
from flexbe_core.core.lockable_state_machine import LockableStateMachine
from flexbe_core.core.manually_transitionable_state import ManuallyTransitionableState
from flexbe_core.core.operatable_state import OperatableState
from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.core.preemptable_state import PreemptableState
from flexbe_core.core.preemptable_state_machine import PreemptableStateMachine
from flexbe_core.core.priority_container import PriorityContainer
from flexbe_core.core.ros_state import RosState
from flexbe_core.core.ros_state_machine import RosStateMachine
from flexbe_core.core.state import State
from flexbe_core.core.state_machine import StateMachine
from flexbe_core.core.user_data import UserData

__all__ = [
    "ConcurrencyContainer",
    "EventState",
    "LockableState",
    "LockableStateMachine",
    "ManuallyTransitionableState",
    "OperatableState",
    "OperatableStateMachine",
    "PreemptableState",
    "PreemptableStateMachine",
    "PriorityContainer",
    "RosState",
    "RosStateMachine",
    "State",
    "StateMachine",
    "UserData",
]
