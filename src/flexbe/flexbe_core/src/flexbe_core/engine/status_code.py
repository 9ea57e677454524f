"""The codes of FlexBE's wire protocol for what an engine does."""

from __future__ import annotations

from enum import IntEnum


class StatusCode(IntEnum):
    """Codes of flexbe_msgs/BEStatus that engines publish."""

    STARTED = 0
    FINISHED = 1
    FAILED = 2
    SWITCHING = 6
    ERROR = 11
    READY = 20
