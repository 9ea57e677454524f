"""Call a service of another node, with a time limit that suits an operator."""

from __future__ import annotations

import threading
from typing import Any

import rospy
from genpy import Message

from remodel_console.core.answer import trouble_words
from remodel_console.errors import CommandError

LIMIT_S = 8.0  # wall time


def call_service(name: str, kind: type, request: Message, limit_s: float = LIMIT_S) -> Any:  # noqa: ANN401 - rospy's answers have no common type
    """Return the answer of a service.

    Args:
        name: of the service.
        kind: its class.
        request: to it.
        limit_s: wall time in which it answers [s]; the service itself must be there earlier.

    Raises:
        CommandError: if no node serves it, it fails, or it does not answer in time.
    """
    answers: list[Message] = []
    mistakes: list[Exception] = []

    def call() -> None:
        try:
            rospy.wait_for_service(name, timeout=min(limit_s, LIMIT_S))
            answers.append(rospy.ServiceProxy(name, kind)(request))
        except (rospy.ROSException, rospy.ServiceException) as error:
            mistakes.append(error)

    calling = threading.Thread(target=call, name=f"call {name}", daemon=True)
    calling.start()
    calling.join(limit_s)
    if answers:
        return answers[0]
    reason = str(mistakes[0]) if mistakes else ""
    raise CommandError(trouble_words(rospy.resolve_name(name), reason, limit_s))
