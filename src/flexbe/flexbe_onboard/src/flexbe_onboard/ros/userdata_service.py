"""Serve the userdata of the running behavior."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import rospy
from flexbe_msgs.msg import UserdataInfo
from flexbe_msgs.srv import GetUserdata, GetUserdataRequest, GetUserdataResponse

from flexbe_core import Behavior


class UserdataService:
    """Serves flexbe/get_userdata.

    A key with a `/` at its start, which no key has, is the path of a state: the answer has what the
    state reads and writes, by its own keys.
    """

    def __init__(self, running: Callable[[], Behavior | None]) -> None:
        """Serve what `running` returns."""
        self._running = running
        rospy.Service("flexbe/get_userdata", GetUserdata, self._answer)

    def _answer(self, request: GetUserdataRequest) -> GetUserdataResponse:
        behavior = self._running()
        if behavior is None:
            return GetUserdataResponse(success=False, message="no behavior is running")
        wanted = request.userdata_key
        if wanted.startswith("/"):
            values = behavior.get_values_at(wanted)
            found = [_info(wanted, key, value) for key, value in values.items()]
        else:
            found = [info for info in _userdata(behavior) if wanted in ("", info.key)]
        if not found:
            text = f"{behavior.name} has no userdata" + (
                f" {'at' if wanted.startswith('/') else 'with key'} {wanted!r}" if wanted else ""
            )
            return GetUserdataResponse(success=False, message=text)
        return GetUserdataResponse(True, f"{len(found)} values of {behavior.name}", found)


def _userdata(behavior: Behavior) -> Iterator[UserdataInfo]:
    for path, data in behavior.get_userdata().items():
        state = f"{behavior.name}{path}/" if path else behavior.name
        for key, value in data.items():
            yield _info(state, key, value)


def _info(state: str, key: str, value: object) -> UserdataInfo:
    return UserdataInfo(state, key, type(value).__name__, str(value))
