"""The fields of topics that are numbers, and their values."""

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

COMMAND = "flexbe/uicommand"  # flexbe_msgs/UICommand
NOTIFICATION = "flexbe/uinotification"  # std_msgs/String: the command done, empty if refused
ANSWER = "flexbe/uianswer"  # std_msgs/String: in words, see core/answer.py
FEEDBACK = "flexbe/command_feedback"  # flexbe_msgs/CommandFeedback, from the engine
UPDATE = "flexbe/behavior_update"  # std_msgs/String: path of the state that is active
STATUS = "flexbe/status"  # flexbe_msgs/BEStatus, from the engine
ATTACH = "flexbe/command/attach"  # std_msgs/UInt8
LOCK = "flexbe/command/lock"  # std_msgs/String
UNLOCK = "flexbe/command/unlock"  # std_msgs/String
REQUEST = "flexbe/outcome_request"  # flexbe_msgs/OutcomeRequest
LOG = "flexbe/log"  # flexbe_msgs/BehaviorLog
HEARTBEAT = "flexbe/heartbeat"  # std_msgs/Empty, once a second
STRUCTURE = "flexbe/mirror/structure"  # flexbe_msgs/ContainerStructure
START = "flexbe/start_behavior"  # flexbe_msgs/BehaviorSelection
AUTONOMY = "flexbe/command/autonomy"  # std_msgs/UInt8
TRANSITION = "flexbe/command/transition"  # flexbe_msgs/OutcomeRequest: index, label of the state
PAUSE = "flexbe/command/pause"  # std_msgs/Bool
REPEAT = "flexbe/command/repeat"  # std_msgs/Empty
PREEMPT = "flexbe/command/preempt"  # std_msgs/Empty
SHOW_STRUCTURE = "flexbe/request_mirror_structure"  # std_msgs/Int32
USERDATA = "flexbe/get_userdata"  # flexbe_msgs/GetUserdata, a service of the engine
BREAKPOINTS = "/flexbe/breakpoints"  # a parameter: paths of states
AUTONOMY_IN_FORCE = "flexbe/mirror/autonomy"  # std_msgs/UInt8, latched: 255 without supervision
OPERATOR_INPUT = "flexbe/operator_input"  # flexbe_msgs/BehaviorInput, an action of the console
VISITS = "flexbe/mirror/visits"  # std_msgs/String: what states find and leave, see VisitText
LEFT = "flexbe/debug/current_state"  # std_msgs/String: path > outcome, of what is supervised
USE_CASE = "remodel/use_case/state"  # remodel_msgs/UseCaseState, latched
TASK_CHANGES = "remodel/use_case/changes"  # remodel_msgs/UseCaseChanges
TASKS = "remodel/use_case/tasks"  # remodel_msgs/GetTasks, a service
RUN_USE_CASE = "remodel/run_use_case"  # remodel_msgs/RunUseCase, an action
RUN_COMMANDS = "remodel/use_case"  # its services: pause, resume, stop, skip, retry ...
CELL = "cell"  # in whose namespace a cell's cameras are


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
