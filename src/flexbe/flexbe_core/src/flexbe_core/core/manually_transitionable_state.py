"""A state that an operator can make take an outcome."""

from __future__ import annotations

from flexbe_core.core.ros_state import RosState


class ManuallyTransitionableState(RosState):
    """A state that an operator can make take an outcome."""
