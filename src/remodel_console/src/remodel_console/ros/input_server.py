"""Serve flexbe/operator_input: values that states ask a person for, answered on any page."""

from __future__ import annotations

import threading
from collections.abc import Callable

import actionlib
from flexbe_msgs.msg import BehaviorInputAction, BehaviorInputResult

from flexbe_core.ros.master import SteadyActionServer
from remodel_console.core.world import InputRequest
from remodel_console.errors import CommandError
from remodel_console.ros import topics


class InputServer:
    """Holds the requests until a person answers or refuses them, or they are cancelled."""

    def __init__(self, report: Callable[[tuple[InputRequest, ...]], None]) -> None:
        """Begin to serve; `report` gets all open requests after each change, on any thread."""
        self._report = report
        self._lock = threading.Lock()
        self._open: dict[int, tuple[InputRequest, actionlib.ServerGoalHandle]] = {}
        self._count = 0
        self._server = SteadyActionServer(
            topics.OPERATOR_INPUT,
            BehaviorInputAction,
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()

    def answer(self, number: int, literal: str) -> None:
        """Send the text of a literal as the value.

        Raises:
            CommandError: if the request is no longer open.
        """
        result = BehaviorInputResult(BehaviorInputResult.RESULT_OK, literal)
        self._take(number).set_succeeded(result, "answered by an operator")

    def refuse(self, number: int) -> None:
        """Enter no value: the state ends with `aborted`.

        Raises:
            CommandError: if the request is no longer open.
        """
        result = BehaviorInputResult(BehaviorInputResult.RESULT_ABORTED, "")
        self._take(number).set_succeeded(result, "an operator entered no value")

    def _take(self, number: int) -> actionlib.ServerGoalHandle:
        with self._lock:
            found = self._open.pop(number, None)
            self._publish()
        if found is None:
            raise CommandError("the request is no longer open: it was answered or withdrawn")
        return found[1]

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        handle.set_accepted()
        with self._lock:
            self._count += 1
            request = InputRequest(self._count, handle.get_goal().msg)
            self._open[self._count] = request, handle
            self._publish()

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        with self._lock:
            for number, (_, held) in tuple(self._open.items()):
                if held == handle:
                    del self._open[number]
            self._publish()
        handle.set_canceled(BehaviorInputResult(), "withdrawn")

    def _publish(self) -> None:
        self._report(tuple(request for request, _ in self._open.values()))
