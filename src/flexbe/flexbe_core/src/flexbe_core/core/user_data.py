"""Userdata, at its stock import path."""

from flexbe_core.engine.user_data import UserData

__all__ = ["UserData"]
