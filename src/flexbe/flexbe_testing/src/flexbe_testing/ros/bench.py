"""What scenarios do to an engine, and what they expect of it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path

import rospy
from flexbe_msgs.msg import BehaviorSelection, BEStatus
from genpy import Message
from std_msgs.msg import Empty, String

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import (
    Fields,
    NotJudgedError,
    ViolationError,
    agrees,
    checksum,
    shown,
)
from flexbe_testing.ros.wire import EVENT, EngineWire

PACKAGE = "flexbe_conformance_behaviors"
# Modules of its behaviors.
CHAIN = "conformance_chain_sm"
NEST = "conformance_nest_sm"
PAIR = "conformance_pair_sm"
PRIORITY = "conformance_priority_sm"
VALUES = "conformance_values_sm"
FAULT = "conformance_fault_sm"
UNSUPERVISED = 255


class StuckError(Exception):
    """The engine does not become idle again; nothing more can be judged."""


class Bench:
    """An engine under test.

    Attributes:
        wire: the connection to the engine.
        limit_s: how long the engine may take for each step [s, wall time].
        quiet_s: how long to wait for what must not happen [s, wall time].
        id: checksum of the source of the behavior that was started last.
    """

    def __init__(self, wire: EngineWire, package: Path, limit_s: float, quiet_s: float) -> None:
        """Test an engine that knows the behaviors of a package.

        Args:
            wire: the connection.
            package: folder of the package flexbe_conformance_behaviors.
            limit_s: see the attributes.
            quiet_s: see the attributes.
        """
        self.wire = wire
        self.limit_s = limit_s
        self.quiet_s = quiet_s
        self.id = 0
        self._package = package
        self._level = UNSUPERVISED
        self._has_mirror = False
        self._tolerated: int | None = None
        self._statuses = -1
        self._sent: list[str] = []

    # Beginning and ending

    def begin(self) -> None:
        """Begin a scenario: forget what came before."""
        self.wire.tape.clear()
        self._sent.clear()
        self._tolerated = None
        self._statuses = -1
        self._level = UNSUPERVISED
        self._has_mirror = bool(self.mirrors())

    def recover(self) -> None:
        """Make the engine idle again, whatever a scenario left behind, also after an interrupt.

        Raises:
            StuckError: if the behavior does not end.
        """
        with self.wire.interrupt.held():
            self._stop_what_runs()

    def _stop_what_runs(self) -> None:
        tape = self.wire.tape
        # After an interrupt the last request may not have been answered yet, but will be.
        within_s = self.limit_s if self.wire.interrupt.is_set else self.quiet_s
        tape.wait(lambda: len(tape.statuses) > self._statuses, within_s)
        # An engine that ends with SWITCHING, and starts nothing, is at rest as well.
        tape.wait(lambda: not tape.is_switching, within_s)
        if tape.is_running:
            self.wire.send_if_heard(topics.PREEMPT, Empty(), self.quiet_s)
            if not tape.wait(lambda: not tape.is_running, self.limit_s):
                raise StuckError("the running behavior did not end after a preempt")

    def drain(self) -> None:
        """Wait until no more messages arrive: late ones belong to a scenario that failed."""
        tape, every = self.wire.tape, (*topics.STRICT, *topics.STRICT_IF_SUPERVISED)
        end = time.monotonic() + self.limit_s
        tape.clear()
        while tape.wait(lambda: any(map(tape.left, every)), self.quiet_s):
            tape.clear()
            if time.monotonic() > end:
                break

    def finish(self) -> None:
        """End a scenario: the engine is idle, and all its messages were expected."""
        strict = topics.STRICT
        if self._level != UNSUPERVISED:
            strict += topics.STRICT_IF_SUPERVISED
        rest = self.quiet_s / 3
        self.wire.tape.wait(lambda: any(self._left(topic) for topic in strict), rest)
        for topic in strict:
            if left := self._left(topic):
                raise ViolationError(f"{topic}: {shown(left[0])} was published besides")
        if self.wire.tape.is_running:
            raise ViolationError("the behavior still runs")

    def _left(self, topic: str) -> list[Message]:
        """Return the unexpected messages, without those that a mirror has caused."""
        left = self.wire.tape.left(topic)
        if topic == topics.FEEDBACK and self._has_mirror:
            left = [message for message in left if not self._is_for_mirror(message)]
        if topic == topics.OUTCOME:
            left = [message for message in left if message.data != self._tolerated]
        return left

    def _is_for_mirror(self, message: Message) -> bool:
        """Return whether a feedback may be there only because of a mirror.

        A mirror asks for a sync at any time, and makes unsupervised behaviors answer a preempt.
        """
        if message.command == "sync":
            return topics.SYNC not in self._sent
        return bool(message.command == "preempt" and self._level == UNSUPERVISED)

    # Doing

    def selection(
        self,
        module: str,
        level: int = UNSUPERVISED,
        args: Mapping[str, str] | None = None,
        inputs: Mapping[str, str] | None = None,
    ) -> BehaviorSelection:
        """Return a start request for a behavior of the conformance package."""
        return BehaviorSelection(
            behavior_id=checksum(f"{PACKAGE}.{module}"),
            behavior_checksum=checksum(self.source(module)),
            autonomy_level=level,
            arg_keys=list(args or {}),
            arg_values=list((args or {}).values()),
            input_keys=list(inputs or {}),
            input_values=list((inputs or {}).values()),
        )

    def source(self, module: str) -> str:
        """Return the source of a behavior."""
        return (self._package / "src" / PACKAGE / f"{module}.py").read_text()

    def request(self, selection: BehaviorSelection) -> None:
        """Send a start request."""
        self.await_answer()
        self.send(topics.START, selection)

    def await_answer(self) -> None:
        """Note that a request follows: the engine is at rest only after it has answered it."""
        self._statuses = len(self.wire.tape.statuses)

    def start(
        self,
        module: str,
        level: int = UNSUPERVISED,
        args: Mapping[str, str] | None = None,
        inputs: Mapping[str, str] | None = None,
    ) -> None:
        """Start a behavior, and expect the status STARTED."""
        selection = self.selection(module, level, args, inputs)
        self._level, self.id = level, selection.behavior_checksum
        self.request(selection)
        self.status(BEStatus.STARTED, [])

    def start_at(self, path: str, module: str, level: int = UNSUPERVISED) -> None:
        """Start a behavior, and expect that it enters its first state."""
        self.start(module, level)
        self.at(path)

    def send(self, topic: str, message: Message) -> None:
        """Send a command."""
        self._sent.append(topic)
        self.wire.send(topic, message)

    def gate(self, label: str, word: str) -> None:
        """Have the gate with this label return an outcome; none if the word is empty."""
        self.wire.send(f"conformance/{label.lower()}", String(word))

    def pass_gate(self, path: str) -> None:
        """Have the gate at a path return `done`, and expect that this supervised state is left."""
        self.gate(path.rpartition("/")[2], "done")
        self.left(path, "done", 0)

    def preempt(self) -> None:
        """Stop the running behavior, and expect that it ends."""
        self.send(topics.PREEMPT, Empty())
        if self._level != UNSUPERVISED:
            self.feedback("preempt")
        self.status(BEStatus.FINISHED, ["preempted"])

    # Expecting

    def expect(self, topic: str, fields: Fields) -> Message:
        """Return the next message of a topic, which must have these fields."""
        message = self.wire.tape.next(topic, self.limit_s)
        if topic == topics.FEEDBACK and self._has_mirror:
            while message is not None and self._is_for_mirror(message):
                if agrees(message, fields):
                    break
                message = self.wire.tape.next(topic, self.limit_s)
        if message is None:
            raise ViolationError(
                f"nothing on {topic} within {self.limit_s:g} s; expected: {dict(fields)}"
            )
        if not agrees(message, fields):
            raise ViolationError(f"{topic}: {shown(message, fields)}; expected: {dict(fields)}")
        return message

    def find(self, topic: str, fields: Fields) -> Message:
        """Return the next message of a topic with these fields; others may precede it."""
        message = self.wire.tape.find(topic, lambda found: agrees(found, fields), self.limit_s)
        if message is None:
            raise ViolationError(
                f"not on {topic} within {self.limit_s:g} s; expected: {dict(fields)}"
            )
        return message

    def status(self, code: int, args: list[str], behavior_id: int | None = None) -> None:
        """Expect a status of the behavior that was started last, or of another."""
        behavior_id = self.id if behavior_id is None else behavior_id
        self.expect(topics.STATUS, {"code": code, "args": args, "behavior_id": behavior_id})

    def finished(self, outcome: str = "finished") -> None:
        """Expect that the behavior ends with an outcome."""
        self.status(BEStatus.FINISHED, [outcome])

    def feedback(self, command: str, *args: str) -> None:
        """Expect the feedback of a command."""
        self.expect(topics.FEEDBACK, {"command": command, "args": list(args)})

    def left(self, path: str, outcome: str, index: int) -> None:
        """Expect what is published of a supervised state that was left."""
        self.expect(topics.OUTCOME, {"data": index})
        self.expect(topics.CURRENT_STATE, {"data": f"{path} > {outcome}"})

    def left_among_others(self, path: str, outcome: str, index: int) -> None:
        """Expect what is published of the first state of a concurrency container that continues.

        To a mirror its outcome is the end of the container. Stock FlexBE publishes it nevertheless,
        and corrects the mirror afterwards; an engine may also correct it at once.
        """
        self.expect(topics.CURRENT_STATE, {"data": f"{path} > {outcome}"})
        self._tolerated = index

    def at(self, path: str) -> None:
        """Expect that a state is entered."""
        self.event(f"enter {path}")

    def event(self, text: str) -> None:
        """Expect an event of a state; others may precede it."""
        if self.wire.tape.find(EVENT, text.__eq__, self.limit_s) is None:
            raise ViolationError(f"no {text!r} within {self.limit_s:g} s")

    def text_event(self, prefix: str) -> str:
        """Return what follows a prefix in an event; others may precede it."""
        found = self.wire.tape.find(EVENT, lambda text: text.startswith(prefix), self.limit_s)
        if found is None:
            raise ViolationError(f"no {prefix!r} within {self.limit_s:g} s")
        return str(found).removeprefix(prefix)

    def in_any_order(self, *expected: str) -> None:
        """Expect these events of the states, in any order; others may come between them."""
        missing = set(expected)
        while missing:
            found = self.wire.tape.find(EVENT, missing.__contains__, self.limit_s)
            if found is None:
                raise ViolationError(f"no {min(missing)!r} within {self.limit_s:g} s")
            missing.discard(found)

    def never(self, text: str, why: str) -> None:
        """Expect that an event does not come for a while."""
        tape = self.wire.tape
        if tape.wait(lambda: text in tape.left(EVENT), self.quiet_s):
            raise ViolationError(f"{text!r} although {why}")

    def events(self, *expected: str) -> None:
        """Expect these events of the states, in this order and no others between them."""
        for text in expected:
            found = self.wire.tape.next(EVENT, self.limit_s)
            if found != text:
                raise ViolationError(f"event {found!r}; expected: {text!r}")

    def stays(self, why: str) -> None:
        """Expect that no state is entered or left for a while, and that the behavior continues.

        Args:
            why: what keeps the state active, for the text of a violation.
        """
        tape = self.wire.tape
        moved = ("enter", "exit", "stop")

        def has_moved() -> bool:
            return not tape.is_running or any(e.startswith(moved) for e in tape.left(EVENT))

        if tape.wait(has_moved, self.quiet_s):
            raise ViolationError(f"a state was left although {why}")

    def silent(self, topic: str, why: str) -> None:
        """Expect that nothing is published on a topic for a while."""
        if self.wire.tape.wait(lambda: bool(self._left(topic)), self.quiet_s):
            message = shown(self.wire.tape.left(topic)[0])
            raise ViolationError(f"{topic}: {message} was published although {why}")

    def next_beat(self) -> None:
        """Wait for the next heartbeat: what was changed before has reached the engine by then."""
        count = len(self.wire.tape.beats)
        self.wire.tape.wait(lambda: len(self.wire.tape.beats) > count, self.limit_s)

    # What may be missing

    def mirrors(self) -> list[str]:
        """Return the mirrors that follow the engine."""
        return self.wire.publishers(topics.REQUEST_STRUCTURE)

    def require_unwatched(self) -> None:
        """Judge only if there is no mirror: it makes every behavior supervised."""
        if mirrors := self.mirrors():
            raise NotJudgedError(f"{mirrors[0]} is a mirror, which makes all behaviors supervised")

    def require_service(self, name: str) -> None:
        """Judge only if a service is there."""
        try:
            rospy.wait_for_service(name, self.quiet_s)
        except rospy.ROSException:
            raise NotJudgedError(f"there is no service {name}") from None
