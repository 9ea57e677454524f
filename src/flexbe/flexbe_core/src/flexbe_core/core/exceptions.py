"""The exceptions of stock FlexBE's API, at their stock import path."""

from flexbe_core.engine.user_data import StateError, StateMachineError, UserDataError

__all__ = ["StateError", "StateMachineError", "UserDataError"]
