"""Userdata, at its stock import path."""

from flexbe_core.engine.userdata.user_data import UserData

__all__ = ["UserData"]
