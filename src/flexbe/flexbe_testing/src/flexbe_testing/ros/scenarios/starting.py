"""Status and heartbeat without any command, start requests, switching, and the action server."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorExecutionAction,
    BehaviorExecutionGoal,
    BehaviorModification,
    BehaviorSelection,
    BEStatus,
    OutcomeRequest,
)
from genpy import Message
from std_msgs.msg import String

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import NotJudgedError, ViolationError, checksum, scenario
from flexbe_testing.ros.bench import CHAIN, FAULT, NEST, VALUES, Bench
from flexbe_testing.ros.wire import EVENT

_BEATS = 4
# [s] Mean time between heartbeats; 1 Hz, with room for a busy machine.
_SHORTEST_BEAT_S, _LONGEST_BEAT_S = 0.8, 1.25


@scenario(
    "A behavior of the package starts, with all topics advertised, and a preempt ends it", "3.2"
)
def runs_behaviors(bench: Bench) -> None:
    """Also connects everything, so that no later scenario loses a first message."""
    bench.start(CHAIN, 3)
    if missing := bench.wire.await_subscribed():
        raise ViolationError(f"not published while a behavior runs: {', '.join(missing)}")
    bench.preempt()


@scenario("An engine that has run nothing publishes READY with behavior_id 0 and no args", "3.2")
def ready(bench: Bench) -> None:
    """The first status received is the latched one."""
    tape = bench.wire.tape
    if not tape.wait(lambda: bool(tape.statuses), bench.limit_s):
        raise ViolationError(f"no status within {bench.limit_s:g} s; it must be latched")
    first = tape.statuses[0]
    if first.code != BEStatus.READY:
        raise NotJudgedError("the engine has run behaviors before; restart it to judge this")
    if first.behavior_id != 0 or first.args:
        raise ViolationError(f"READY carries id {first.behavior_id} and args {first.args}")


@scenario("The last status is latched: a later subscriber receives it", "3.2")
def status_is_latched(bench: Bench) -> None:
    """Subscribe again after a run."""
    bench.start(CHAIN)
    bench.preempt()
    bench.wire.subscribe_again(topics.STATUS)
    bench.status(BEStatus.FINISHED, ["preempted"])


@scenario("The heartbeat beats once per second, idle or not", "3.2")
def heartbeat(bench: Bench) -> None:
    """Judge all beats since the kit began."""
    beats = bench.wire.tape.beats
    if not bench.wire.tape.wait(lambda: len(beats) >= _BEATS, bench.limit_s):
        raise ViolationError(f"{len(beats)} beats within {bench.limit_s:g} s")
    mean_s = (beats[-1] - beats[0]) / (len(beats) - 1)
    if not _SHORTEST_BEAT_S <= mean_s <= _LONGEST_BEAT_S:
        raise ViolationError(f"one beat per {mean_s:.2f} s")


@scenario("All topics have the types of stock FlexBE", "3.2")
def topic_types(bench: Bench) -> None:
    """Compare what the master knows; messages with other sums would not arrive at all."""
    known = bench.wire.topic_types()
    for topic, kind in {**topics.PUBLISHED, **topics.COMMANDS}.items():
        found = known.get(rospy.resolve_name(topic), kind)
        if found not in (kind, "*"):
            raise ViolationError(f"{topic} has type {found}; expected: {kind}")


# Start requests: the order of events, parameters, inputs, refusals


_RUNS = 5


@scenario("STARTED and FINISHED carry the source's checksum; FINISHED carries the outcome", "3.2")
def runs_to_the_end(bench: Bench) -> None:
    """Run to one outcome, then to the other."""
    for word, outcome in (("done", "finished"), ("other", "failed")):
        bench.start_at("/First", CHAIN)
        bench.gate("First", word)
        if word == "done":
            bench.at("/Second")
            bench.gate("Second", word)
        bench.finished(outcome)


@scenario(
    "on_start of all states depth first, on_enter and on_exit per visit, on_stop of all", "2.2"
)
def order_of_events(bench: Bench) -> None:
    """Play a nested behavior to its end."""
    visited = ["/Box/Inner/Leaf", "/Box/Last", "/After"]
    states = ["/Box/Inner/Leaf", "/Box/Inner/Tail", "/Box/Last", "/After"]
    bench.start(NEST)
    bench.events(*(f"start {path}" for path in states))
    for path, word in zip(visited, ("other", "done", "done"), strict=True):
        bench.events(f"enter {path}")
        bench.gate(path.rpartition("/")[2], word)
        bench.events(f"exit {path}")
    bench.in_any_order(*(f"stop {path}" for path in states))
    bench.finished()
    if left := bench.wire.tape.left(EVENT):
        raise ViolationError(f"event {left[0]!r} besides")


@scenario("The next behavior may be started as soon as the last has FINISHED", "3.2")
def next_behavior_at_once(bench: Bench) -> None:
    """Start right after the status."""
    for _ in range(_RUNS):
        bench.start_at("/First", CHAIN)
        bench.gate("First", "other")
        bench.finished("failed")


def _values(bench: Bench, args: dict[str, str], piece: str | None = None) -> dict[str, Any]:
    """Return the values that the state in the contained behavior received."""
    bench.start(VALUES, args=args, inputs=None if piece is None else {"piece": piece})
    found: dict[str, Any] = json.loads(bench.text_event("values "))
    bench.at("/Hold")
    bench.gate("Hold", "done")
    bench.finished()
    return found


def _require(found: dict[str, Any], **expected: object) -> None:
    for name, value in expected.items():
        if found[name] != value or type(found[name]) is not type(value):
            raise ViolationError(f"{name} is {found[name]!r}; expected: {value!r}")


@scenario("Parameters become the type of their default: text, float, int, bool", "2.6")
def parameter_types(bench: Bench) -> None:
    """Send texts for all types; two spellings of False."""
    sent = {"word": "7", "size": "2.25", "count": "40", "is_new": "False"}
    _require(_values(bench, sent), word="7", size=2.25, count=40, is_new=False)
    _require(_values(bench, {"is_new": "0"}), word="part", size=1.5, count=2, is_new=False)


@scenario("A parameter is named `key`, `/key` or `/Contained/key`", "2.6")
def parameter_paths(bench: Bench) -> None:
    """Reach the contained behavior with each spelling."""
    for name in ("word", "/word", "/Part/word"):
        _require(_values(bench, {name: f"by {name}"}), word=f"by {name}")


@scenario("A parameter that no behavior has does not stop the start", "3.2")
def parameter_unknown(bench: Bench) -> None:
    """Send it beside one that exists."""
    _require(_values(bench, {"no_such_key": "1", "word": "known"}), word="known")


@scenario("Inputs are Python literals; dicts allow attribute access; other text stays text", "3.2")
def inputs(bench: Bench) -> None:
    """Send a dict, a number and a text."""
    _require(_values(bench, {}, "{'pins': [1, 2]}"), pins=[1, 2])
    _require(_values(bench, {}, "17"), part="17")
    _require(_values(bench, {}, "wire A 7"), part="wire A 7")
    _require(_values(bench, {}), part="nothing")


def _refused(bench: Bench, selection: BehaviorSelection) -> None:
    bench.request(selection)
    bench.status(BEStatus.ERROR, [], selection.behavior_checksum)


@scenario("An unknown behavior_id is refused with ERROR and the request's checksum", "3.2")
def unknown_behavior(bench: Bench) -> None:
    """Send an id that no package path has."""
    selection = bench.selection(CHAIN)
    selection.behavior_id = checksum("no_such_package.no_such_module")
    _refused(bench, selection)


@scenario("A checksum of another source is refused with ERROR", "3.2")
def other_checksum(bench: Bench) -> None:
    """Send the right id with another checksum; the engine remains usable."""
    selection = bench.selection(CHAIN)
    selection.behavior_checksum ^= 1
    _refused(bench, selection)
    bench.start(CHAIN)
    bench.preempt()


@scenario("A parameter value that cannot be converted is refused with ERROR", "3.2")
def bad_parameter_value(bench: Bench) -> None:
    """Send a word for a float."""
    _refused(bench, bench.selection(VALUES, args={"size": "large"}))


@scenario("A behavior whose create() raises is refused with ERROR", "3.2")
def create_raises(bench: Bench) -> None:
    """Nothing is started."""
    _refused(bench, bench.selection(FAULT, args={"how": "create"}))


@scenario("A behavior whose on_start raises ends with FAILED", "3.2")
def on_start_raises(bench: Bench) -> None:
    """STARTED may or may not precede. Supervised, no other exception ends a behavior."""
    bench.request(selection := bench.selection(FAULT, 3, args={"how": "start"}))
    failed = {"code": BEStatus.FAILED, "behavior_id": selection.behavior_checksum, "args": []}
    bench.find(topics.STATUS, failed)


@scenario("Modifications replace half-open ranges of characters, in ascending order", "3.2")
def modifications(bench: Bench) -> None:
    """Swap the targets of two outcomes in the source that is sent along."""
    text = bench.source(CHAIN)
    changes = [('"done": "finished"', '"done": "failed"'), ('"Conformance', '"Conformance')]
    changes.sort(key=lambda change: text.index(change[0]))
    selection, changed = bench.selection(CHAIN), text
    for old, new in changes:
        begin = text.index(old)
        selection.modifications.append(BehaviorModification(begin, begin + len(old), new))
        changed = changed.replace(old, new, 1)
    selection.behavior_checksum = bench.id = checksum(changed)
    bench.request(selection)
    begun = bench.find(topics.STATUS, {"behavior_id": bench.id})
    if begun.code == BEStatus.ERROR:
        raise NotJudgedError("the engine refuses modifications; perhaps an option allows them")
    bench.at("/First")
    bench.gate("First", "done")
    bench.at("/Second")
    bench.gate("Second", "done")
    bench.finished("failed")


# Start requests while a behavior runs


@scenario("A request for the running behavior switches: its active state continues, locked", "3.2")
def switch_keeps_the_state(bench: Bench) -> None:
    """Unlock it at the end, as an operator does."""
    bench.start_at("/First", CHAIN, 3)
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.request(bench.selection(CHAIN, 3))
    for phase in ("received", "start", "prepared"):
        bench.feedback("switch", phase)
    bench.status(BEStatus.SWITCHING, [])
    bench.status(BEStatus.STARTED, ["/Second"])
    bench.send(topics.TRANSITION, OutcomeRequest(0, "Second"))
    bench.feedback("transition", "Second", "Second")
    bench.send(topics.UNLOCK, String("/Second"))
    bench.feedback("unlock", "/Second", "/Second")
    bench.left("/Second", "done", 0)
    bench.finished()


def _goes_on(bench: Bench) -> None:
    """Expect that the refused request has changed nothing."""
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.pass_gate("/Second")
    bench.finished()


@scenario(
    "A request for another behavior is refused, and the running one ends with FINISHED", "3.2"
)
def switch_to_another_is_refused(bench: Bench) -> None:
    """Stock FlexBE 1.4.1 ends it with SWITCHING, its known defect 2."""
    bench.start_at("/First", CHAIN, 3)
    other = bench.selection(NEST, 3)
    bench.request(other)
    bench.feedback("switch", "received")
    answer = bench.expect(topics.FEEDBACK, {"command": "switch"}).args
    if answer not in (["not_switchable"], ["failed"]):
        raise ViolationError(f"switch {answer}; expected: not_switchable or failed")
    bench.status(BEStatus.ERROR, [], other.behavior_checksum)
    _goes_on(bench)


@scenario(
    "A request that cannot be prepared is refused with `failed`; the running one continues", "3.2"
)
def switch_to_unknown_is_refused(bench: Bench) -> None:
    """An id that no package path has."""
    bench.start_at("/First", CHAIN, 3)
    unknown = bench.selection(CHAIN, 3)
    unknown.behavior_id = checksum("no_such_package.no_such_module")
    unknown.behavior_checksum = 1
    bench.request(unknown)
    bench.feedback("switch", "received")
    bench.find(topics.FEEDBACK, {"command": "switch", "args": ["failed"]})
    bench.status(BEStatus.ERROR, [], 1)
    _goes_on(bench)


# The action server that starts behaviors, if there is one


_CANCELLED = (GoalStatus.SUCCEEDED, GoalStatus.PREEMPTED)
_NOT_DONE = (GoalStatus.REJECTED, GoalStatus.PREEMPTED, GoalStatus.ABORTED)


class _Goal:
    """One goal at the action server."""

    def __init__(self, bench: Bench, name: str, **args: str) -> None:
        if not bench.wire.is_subscribed(f"{topics.EXECUTE_ACTION}/goal"):
            raise NotJudgedError(f"there is no action server {topics.EXECUTE_ACTION}")
        self._bench = bench
        self._news = threading.Condition()
        self._paths: list[str] = []
        self._client = actionlib.ActionClient(topics.EXECUTE_ACTION, BehaviorExecutionAction)
        poll = rospy.Duration(0.05)
        if not bench.wire.until(lambda: self._client.wait_for_server(poll)):
            raise ViolationError(f"{topics.EXECUTE_ACTION} does not connect")
        goal = BehaviorExecutionGoal(
            behavior_name=name, arg_keys=list(args), arg_values=list(args.values())
        )
        bench.await_answer()
        self._handle = self._client.send_goal(goal, self._on_transition, self._on_feedback)

    def cancel(self) -> None:
        """Cancel the goal."""
        self._handle.cancel()

    def shows(self, path: str) -> None:
        """Expect the feedback that this state is active."""
        with self._news:
            if not self._wait(lambda: path in self._paths):
                raise ViolationError(f"feedback {self._paths}; expected: {path}")

    def ended(self, is_right: Callable[[int, str], bool], expected: str) -> None:
        """Expect an end of the goal, by its status and outcome."""
        with self._news:
            if not self._wait(self._is_done):
                raise ViolationError(f"the goal did not end within {self._bench.limit_s:g} s")
        status, result = self._handle.get_goal_status(), self._handle.get_result()
        outcome = result.outcome if result else ""
        if not is_right(status, outcome):
            raise ViolationError(f"goal status {status}, outcome {outcome!r}; expected: {expected}")

    def _wait(self, condition: Callable[[], bool]) -> bool:
        bench = self._bench
        return bench.wire.interrupt.wait_for(self._news, condition, bench.limit_s)

    def _is_done(self) -> bool:
        return self._handle.get_comm_state() == actionlib.CommState.DONE

    def _on_transition(self, handle: actionlib.ClientGoalHandle) -> None:
        with self._news:
            self._news.notify_all()

    def _on_feedback(self, handle: actionlib.ClientGoalHandle, feedback: Message) -> None:
        with self._news:
            self._paths.append(feedback.current_state)
            self._news.notify_all()


def _started(bench: Bench, name: str, module: str) -> _Goal:
    """Send a goal, and expect that the behavior starts."""
    bench.id = checksum(bench.source(module))
    goal = _Goal(bench, name)
    bench.status(BEStatus.STARTED, [])
    return goal


@scenario("A goal runs a behavior, shows its active path, and succeeds with its outcome", "3.5")
def action_succeeds(bench: Bench) -> None:
    """The path is shown if a mirror or the engine publishes it."""
    goal = _started(bench, "Conformance Chain", CHAIN)
    bench.at("/First")
    if bench.wire.publishers(topics.UPDATE):
        goal.shows("/First")
    bench.gate("First", "other")
    bench.finished("failed")
    goal.ended(
        lambda status, outcome: status == GoalStatus.SUCCEEDED and outcome == "failed",
        "SUCCEEDED (3) with 'failed'",
    )


@scenario("A goal for an unknown behavior ends without success or outcome", "3.5")
def action_unknown_behavior(bench: Bench) -> None:
    """Stock ends it with PREEMPTED; REJECTED and ABORTED are as clear."""
    goal = _Goal(bench, "No Such Behavior")
    goal.ended(
        lambda status, outcome: status in _NOT_DONE and not outcome,
        "PREEMPTED, REJECTED or ABORTED",
    )


@scenario("A cancelled goal preempts the behavior, and its outcome is `preempted`", "3.5")
def action_is_cancelled(bench: Bench) -> None:
    """Stock ends the goal with SUCCEEDED; PREEMPTED is as clear."""
    goal = _started(bench, "Conformance Chain", CHAIN)
    bench.at("/First")
    goal.cancel()
    bench.status(BEStatus.FINISHED, ["preempted"])
    goal.ended(
        lambda status, outcome: status in _CANCELLED and outcome == "preempted",
        "SUCCEEDED or PREEMPTED with 'preempted'",
    )


@scenario("A goal whose behavior cannot be built is aborted", "3.5")
def action_is_aborted(bench: Bench) -> None:
    """The engine refuses it with ERROR."""
    goal = _Goal(bench, "Conformance Fault", how="create")
    bench.status(BEStatus.ERROR, [], checksum(bench.source(FAULT)))
    goal.ended(lambda status, outcome: status == GoalStatus.ABORTED and not outcome, "ABORTED (4)")
