"""Any topic as values to plot.

A topic is subscribed to by its own message class: another subscriber of this node to the same
topic would receive what the first one's class makes of it.
"""

from __future__ import annotations

import threading
import xmlrpc.client
from collections.abc import Callable
from functools import partial

import rosgraph
import roslib.message
import rospy

from remodel_console.core.run.topic_plot import check_field, number_fields, number_in, split_plot
from remodel_console.errors import CommandError
from remodel_console.watched import TopicPlots

_CALLER = "/remodel_console"
_CHECK_S = 0.5  # between two checks of what is to be plotted


class TopicValues:
    """Subscribes to the topics of plots while pages show them."""

    def __init__(
        self, plots: TopicPlots, chosen: Callable[[], tuple[str, ...]], end: threading.Event
    ) -> None:
        """Follow what is chosen until the event is set."""
        self._plots = plots
        self._chosen = chosen
        self._end = end
        self._subscribers: dict[str, rospy.Subscriber] = {}
        threading.Thread(target=self._watch, name="plots", daemon=True).start()

    def topics(self) -> dict[str, str]:
        """Return the message types of all topics that a node publishes, by their names."""
        try:
            return dict(sorted(rosgraph.Master(_CALLER).getPublishedTopics("")))
        except (OSError, xmlrpc.client.Error, rosgraph.MasterError) as error:
            raise CommandError("the ROS master does not answer; start it: roscore") from error

    def fields(self, topic: str) -> tuple[str, ...]:
        """Return the fields of a topic that are numbers.

        Raises:
            CommandError: if no node publishes it, or its type is not built here.
        """
        return tuple(number_fields(self._kind(topic), _fields_of))

    def check(self, plot: str) -> None:
        """Refuse what cannot be plotted.

        Raises:
            CommandError: if there is no such topic, or its field is no number.
        """
        self._parsed(plot)

    def _parsed(self, plot: str) -> tuple[str, str, str]:
        """Return topic, field and message type of a plot."""
        try:
            topic, field = split_plot(plot)
            kind = self._kind(topic)
            check_field(field, kind, tuple(number_fields(kind, _fields_of)))
        except ValueError as error:
            raise CommandError(str(error)) from error
        return topic, field, kind

    def _kind(self, topic: str) -> str:
        kinds = self.topics()
        if topic not in kinds:
            raise CommandError(f"no node publishes {topic}; rostopic list prints what there is")
        return kinds[topic]

    def _watch(self) -> None:
        while not self._end.wait(_CHECK_S):
            chosen = self._chosen() if self._plots.is_wanted else ()
            for plot in set(self._subscribers) - set(chosen):
                self._subscribers.pop(plot).unregister()
            self._plots.keep(chosen)  # no line leads over the time in which nothing was received
            for plot in set(chosen) - set(self._subscribers):
                self._subscribe(plot)

    def _subscribe(self, plot: str) -> None:
        try:
            topic, field, kind = self._parsed(plot)
        except CommandError as error:
            self._plots.report(plot, str(error))
            return
        take = partial(self._take, plot, field)
        self._subscribers[plot] = rospy.Subscriber(topic, _class_of(kind), take)

    def _take(self, plot: str, field: str, message: object) -> None:
        try:
            self._plots.add(plot, number_in(message, field))
        except IndexError:
            self._plots.report(plot, f"the messages have no element {field}")


def _fields_of(kind: str) -> list[tuple[str, str]]:
    message = _class_of(kind)
    return list(zip(message.__slots__, message._slot_types, strict=True))


def _class_of(kind: str) -> type[rospy.Message]:
    found = roslib.message.get_message_class(kind)
    if found is None:
        text = f"the message type {kind} is not built in this workspace; "
        raise CommandError(f"{text}build its package, source it, and start the console again")
    return found  # type: ignore[no-any-return]
