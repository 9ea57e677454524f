"""What the launch file chooses."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TypeVar

import rospy

from flexbe_core.engine.engine import ErrorPolicy
from flexbe_onboard.core.hang import HangPolicy
from flexbe_onboard.errors import OptionError

Choice = TypeVar("Choice", bound=Enum)

# [s] Wall time; no state of this project takes a tenth of it for one execution.
DEFAULT_HANG_LIMIT_S = 10.0


@dataclass(frozen=True)
class Options:
    """What the launch file chooses.

    Attributes:
        modifications: apply source changes that come with a request.
        start_at: start behaviors at any of their states, if a request says so.
        enable_clear_imports: import modules of behaviors and states again for each run.
        on_error: what happens when a state raises.
        hang_limit_s: [s] wall time of one execution that counts as a hang; 0 for none.
        on_hang: what happens when a state does not return.
    """

    modifications: bool = False
    start_at: bool = False
    enable_clear_imports: bool = False
    on_error: ErrorPolicy = ErrorPolicy.AUTO
    hang_limit_s: float = DEFAULT_HANG_LIMIT_S
    on_hang: HangPolicy = HangPolicy.REPORT


def read_options(modifications: bool = False) -> Options:
    """Return the options that the node's private parameters choose.

    Args:
        modifications: whether source changes are applied if the parameter is not set.

    Raises:
        OptionError: if a parameter is invalid.
    """
    return Options(
        modifications=bool(rospy.get_param("~modifications", modifications)),
        start_at=bool(rospy.get_param("~start_at", False)),
        enable_clear_imports=bool(rospy.get_param("~enable_clear_imports", False)),
        on_error=_choice("~on_error", ErrorPolicy.AUTO),
        hang_limit_s=_seconds("~hang_limit_s", DEFAULT_HANG_LIMIT_S),
        on_hang=_choice("~on_hang", HangPolicy.REPORT),
    )


def _choice(name: str, default: Choice) -> Choice:
    found = rospy.get_param(name, default.value)
    for member in type(default):
        if member.value == found:
            return member
    known = ", ".join(str(member.value) for member in type(default))
    raise OptionError(f"{name} must be one of {known}; found {found!r}")


def _seconds(name: str, default: float) -> float:
    found = rospy.get_param(name, default)
    if isinstance(found, int | float) and not isinstance(found, bool) and 0 <= found < float("inf"):
        return float(found)
    raise OptionError(f"{name} must be a number of seconds, 0 or more; found {found!r}")
