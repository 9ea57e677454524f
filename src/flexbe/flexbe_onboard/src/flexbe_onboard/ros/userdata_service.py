"""Serve the userdata of the running behavior."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import rospy
from flexbe_msgs.msg import UserdataInfo
from flexbe_msgs.srv import GetUserdata, GetUserdataRequest, GetUserdataResponse

from flexbe_core import Behavior


class UserdataService:
    """Serves flexbe/get_userdata."""

    def __init__(self, running: Callable[[], Behavior | None]) -> None:
        """Serve what `running` returns."""
        self._running = running
        rospy.Service("flexbe/get_userdata", GetUserdata, self._answer)

    def _answer(self, request: GetUserdataRequest) -> GetUserdataResponse:
        behavior = self._running()
        if behavior is None:
            return GetUserdataResponse(success=False, message="no behavior is running")
        wanted = request.userdata_key
        found = [info for info in _userdata(behavior) if wanted in ("", info.key)]
        if not found:
            text = f"{behavior.name} has no userdata" + (f" with key {wanted!r}" if wanted else "")
            return GetUserdataResponse(success=False, message=text)
        return GetUserdataResponse(True, f"{len(found)} values of {behavior.name}", found)


def _userdata(behavior: Behavior) -> Iterator[UserdataInfo]:
    for path, data in behavior.get_userdata().items():
        state = f"{behavior.name}{path}/" if path else behavior.name
        for key, value in data.items():
            yield UserdataInfo(state, key, type(value).__name__, str(value))
