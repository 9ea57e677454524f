"""A state whose outcome an operator withholds does its work once, and wants the same outcome.

The engine executes a state again and again while it waits for the operator's consent. So what a
state does besides returning its outcome (sending, publishing, logging, writing userdata) belongs
into `on_enter`, or happens once. Every state of the product is run here with its outcome withheld
for some ticks, and beside it at once; what the two did is compared.
"""

import ast
import importlib
import itertools
from pathlib import Path
from types import SimpleNamespace

import pytest
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import BehaviorInputResult
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String

from flexbe_core import OperatableStateMachine
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.supervision import SetAutonomy
from flexbe_core.engine.user_data import UserData
from flexbe_core.proxy import ProxyActionClient, ProxyPublisher, ProxySubscriberCached
from flexbe_states import subscriber_state
from remodel_states import line

SRC = Path(__file__).parents[1] / "src"
PACKAGES = ("remodel_states", "flexbe/flexbe_states")
FILES = [file for package in PACKAGES for file in sorted(SRC.glob(f"{package}/src/*/*_state.py"))]
TICKS = 20


def another_each_time(values):
    """Return a function that returns one value after the other."""
    following = itertools.cycle(values)
    return lambda *_, **__: next(following)


# What the states are made with, by the name of the parameter.
ARGUMENTS = {
    "attempts": lambda: 1,
    "blocking": lambda: True,
    "calculation": lambda: another_each_time(range(99)),
    "conditions": lambda: another_each_time("ab"),
    "connector_id": lambda: "P1",
    "data": lambda: {"a": 1},
    "input_keys": lambda: ["input_value"],
    "message": lambda: "Which?",
    "outcomes": lambda: ["a", "b"],
    "path": lambda: [[0.1, 0.2, 0.0, 0.0]],
    "predicate": lambda: another_each_time([True, False]),
    "request": lambda: 0,
    "suggestion": lambda: "a",
    "target": lambda: [0.1, 0.2, 0.0, 0.0],
    "text": lambda: "it is {}",
    "topic": lambda: "a_topic",
    "wait_time": lambda: 0.0,
}
# Given although the states have defaults for them.
GIVEN = {"blocking", "suggestion"}
VALUES = {"attempt": 0, "cable_end": 0, "socket_pose": PoseStamped(), "value": True}


class Answers:
    """What is outside the state: a server that has answered, a topic with two messages.

    Attributes:
        deeds: what the state has done to it.
    """

    def __init__(self, monkeypatch, answer):
        self.deeds = []
        self._answer = answer
        self._goal = None
        self._messages = [String("one"), String("two")]
        for owner in (ProxyActionClient, ProxyPublisher):
            monkeypatch.setattr(owner, "__init__", lambda *_, **__: None)
        for owner, method, does in (
            (ProxyPublisher, "publish", self._note("publish")),
            (ProxyActionClient, "send_goal", self._send),
            (ProxyActionClient, "cancel", self._note("cancel")),
            (ProxyActionClient, "is_available", lambda *_: True),
            (ProxyActionClient, "servers", lambda *_: ()),
            (ProxyActionClient, "has_result", lambda *_: True),
            (ProxyActionClient, "get_result", lambda *_: self._result()),
            (ProxyActionClient, "get_state", lambda *_: self._status()),
            (ProxyActionClient, "get_goal_status_text", lambda *_: "so it is"),
            (ProxySubscriberCached, "subscribe", lambda *_, **__: None),
            (ProxySubscriberCached, "has_msg", lambda *_: bool(self._messages)),
            (ProxySubscriberCached, "get_last_msg", lambda *_: (self._messages or [None])[0]),
            (line, "recorder", lambda: ""),
            (rospy, "get_time", lambda: 100.0),
            (rospy.Time, "now", lambda: rospy.Time(100)),
        ):
            monkeypatch.setattr(owner, method, does)
        monkeypatch.setattr(ProxySubscriberCached, "remove_last_msg", self._take)
        types = SimpleNamespace(getTopicTypes=lambda: [["/a_topic", "std_msgs/String"]])
        monkeypatch.setattr(subscriber_state.rosgraph, "Master", lambda _: types)

    def _note(self, what):
        return lambda _self, *rest: self.deeds.append((what, *map(str, rest)))

    def _send(self, topic, goal):
        self._goal = goal
        self.deeds.append(("send", topic, str(goal)))

    def _take(self, *_):
        self._messages = self._messages[1:]

    def _result(self):
        if not hasattr(self._goal, "id"):
            return BehaviorInputResult(int(self._answer == "failure"), "no literal'")
        action = type(self._goal).__name__.removesuffix("Goal")
        result = getattr(importlib.import_module("remodel_msgs.msg"), f"{action}Result")()
        result.id, result.success = self._goal.id, self._answer == "success"
        result.error_code = 0 if result.success else 300
        return result

    def _status(self):
        return GoalStatus.SUCCEEDED if self._answer == "success" else GoalStatus.ABORTED


def made(file, wanted):
    """Return a new state of the class in a file, which notes the outcomes that it wants."""
    (name,) = [n.name for n in ast.parse(file.read_text()).body if isinstance(n, ast.ClassDef)]
    kind = getattr(importlib.import_module(f"{file.parent.name}.{file.stem}"), name)
    code = kind.__init__.__code__
    names = code.co_varnames[1 : code.co_argcount]
    needed = names[: len(names) - len(kind.__init__.__defaults__ or ())]

    def execute(self, userdata):
        wanted.append(kind.execute(self, userdata))
        return wanted[-1]

    noting = type(name, (kind,), {"execute": execute})
    return noting(**{n: ARGUMENTS[n]() for n in names if n in needed or n in GIVEN})


def run(file, withheld):
    """Run the state of a file; return how it ends, what it wanted until then, and its userdata."""
    wanted = []
    state = made(file, wanted)
    machine = OperatableStateMachine(outcomes=[f"{name} of it" for name in state.outcomes])
    for key in state.input_keys:
        machine.userdata[key] = VALUES.get(key, "W1")
    targets = {name: f"{name} of it" for name in state.outcomes}
    with machine:
        OperatableStateMachine.add("it", state, targets, dict.fromkeys(targets, 2))
    machine._is_controlled = state._is_controlled = True
    data, engine = UserData(), Engine(machine, ErrorPolicy.FAIL)
    engine.handle(SetAutonomy(0 if withheld else 255))
    engine.begin(data)
    for now in range(withheld):
        assert engine.run(float(now)) is None
    engine.handle(SetAutonomy(255))
    ended = engine.run(float(withheld))
    assert len(wanted) == withheld + 1
    return ended, set(wanted), {key: str(value) for key, value in data._data.items()}


@pytest.mark.parametrize("answer", ["success", "failure"])
def test_what_is_withheld_is_done_once(monkeypatch, answer):
    assert len(FILES) > 25
    different = []
    for file in FILES:
        found = []
        for withheld in (0, TICKS):
            with monkeypatch.context() as patched:
                answers = Answers(patched, answer)
                found.append((*run(file, withheld), answers.deeds))
        at_once, late = found
        if at_once != late:
            different.append(f"{file.stem}: at once {at_once}, withheld {late}")
    assert not different, "\n" + "\n".join(different)
