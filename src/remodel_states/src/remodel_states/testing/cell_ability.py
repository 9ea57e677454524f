"""Action servers of abilities without a robot: of a fake cell, and with scripted answers.

Those with scripted answers are for tests, and for dry runs of behaviors (`rosrun remodel_states
fake_abilities`).
"""

from __future__ import annotations

import fcntl
import math
import os
import signal
import threading
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any

import rospy
from genpy import Message
from remodel_msgs import msg as remodel_msgs
from remodel_msgs.msg import CableObservation, ErrorCode, WireTruth

from remodel_states.ability_server import AbilityServer, Done
from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import owner_of
from remodel_states.core.tables import Ability, chosen_abilities
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.parameters import panel_pose
from remodel_states.serving import Robot, RunningGoal, StoppedError, admitted
from remodel_states.testing.faults import Behaves, InjectedFault, at_goal
from remodel_states.testing.operations import Effect, operation_of, perform
from remodel_states.testing.world import Panel, Place, World
from remodel_states.testing.world_file import WorldFile


@dataclass(frozen=True)
class Site:
    """What the processes of a fake cell share.

    Attributes:
        file: the world.
        lock_path: file that the robot's goals lock.
        cell: name of the cell.
        duration_s: [s] wall time that an operation takes, on average.
        seed: of all that is random.
    """

    file: WorldFile
    lock_path: str
    cell: str
    duration_s: float
    seed: int

    def random(self, ability: str, number: int) -> Random:
        """Return the random numbers of an ability's n-th goal."""
        return Random(f"{self.seed} {self.cell} {ability} {number}")

    def admit(self, owner: int) -> None:
        """Check the token of a supervisor, and remember it if it is the newest; 0 is not checked.

        Raises:
            AbilityError: if it is stale.
        """
        if owner:
            with self.file.change() as draft:
                draft.owners = admitted(draft.owners, self.cell, owner)


class CellRobot(Robot):
    """The robot of a fake cell; several processes may serve its abilities."""

    def __init__(self, site: Site) -> None:
        """Take the site's lock."""
        super().__init__()
        self._site, self._file_lock = site, RobotLock(site.lock_path)

    def begin(self, owner: int) -> None:
        """Lock the robot, and check the token."""
        if not self._file_lock.take():
            raise AbilityError(ErrorCode.BUSY, "the robot is doing another goal; wait for it")
        try:
            self._site.admit(owner)
        except BaseException:
            self.end()
            raise

    def end(self) -> None:
        """Free the robot."""
        self._file_lock.free()


class CellAbility(AbilityServer):
    """Serves one ability; the robot does one goal at a time, over all abilities of the cell."""

    def __init__(self, ability: Ability, site: Site) -> None:
        """Start to serve, on the ability's usual topic."""
        self._site = site
        self._operation = operation_of(ability.name)
        self._fault: InjectedFault | None = None
        self._random = Random()
        super().__init__(ability, CellRobot(site))

    def check(self, goal: Message) -> None:
        """Count a goal that can be done, and choose the fault that strikes it, if any."""
        name = self.ability.name
        with self._site.file.change() as draft:
            self._operation.check(draft.world, self._site.cell, goal)
            included = self._operation.includes(draft.world, self._site.cell, goal)
            draft.faults, self._fault = at_goal(draft.faults, name, goal, included)
            number = draft.goals[name] = draft.goals.get(name, 0) + 1
        self._random = self._site.random(name, number)

    def perform(self, running: RunningGoal) -> Done:
        """Do the goal, as far as its fault lets it."""
        fault, random = self._fault, self._random
        course = Course.drawn(random, self._site.duration_s)
        goal = CourseOfGoal(running, course)
        behaves = fault.behaves if fault else None
        happens = behaves is None or random.random() < 0.5
        goal.wait_until(course.effect_s)
        code = fault.code if fault and behaves is None else 0
        effect = self._take_effect(running.goal, code) if happens else None
        if behaves is Behaves.DIES:
            os.kill(os.getpid(), signal.SIGKILL)
        if behaves is Behaves.HANGS:
            goal.hang()
        goal.wait_until(course.end_s)
        if fault and behaves is None:
            raise AbilityError(fault.code, f"{fault.name}, strike {fault.struck}")
        said = effect.said if effect else ""
        found = {**self.ability.fake, **result_fields(effect.found if effect else {})}
        if fault:
            contradiction = {"success": True, "message": said}
            raise AbilityError(ErrorCode.INTERNAL, fault.name, {**found, **contradiction})
        return Done(said, found)

    def _take_effect(self, goal: Message, code: int) -> Effect:
        cell = self._site.cell
        with self._site.file.change() as draft:
            admitted(draft.owners, cell, owner_of(goal.id))  # it may have lost the cell since
            effect = perform(self.ability.name, draft.world, cell, goal, code=code)
            draft.world = effect.world
            draft.entries += effect.entries
        return effect


# The course of a fake operation in time


# [s] Wall time between two feedbacks.
_FEEDBACK_S = 0.2


@dataclass(frozen=True)
class Course:
    """When an operation takes effect, and when it ends: [s] wall time from its start."""

    effect_s: float
    end_s: float

    @classmethod
    def drawn(cls, random: Random, mean_s: float) -> Course:
        """Draw a course: a little shorter or longer than usual, the effect anywhere in it."""
        end_s = mean_s * random.uniform(0.5, 1.5)
        return cls(random.uniform(0.0, end_s), end_s)


class CourseOfGoal:
    """The course of a goal that begins now; its timeout is taken as wall time too."""

    def __init__(self, running: RunningGoal, course: Course) -> None:
        """Begin."""
        self._running = running
        self._course = course
        self._began = time.monotonic()

    def wait_until(self, at_s: float) -> None:
        """Wait until a time of the course [s], and report progress.

        Raises:
            StoppedError: if the goal is cancelled, or its timeout passes.
        """
        timeout_s = self._running.goal.timeout
        until = self._began + min(at_s, timeout_s)
        while (left := until - time.monotonic()) > 0:
            self._wait(min(left, _FEEDBACK_S))
            share = 100.0 * min(1.0, (time.monotonic() - self._began) / self._course.end_s)
            self._running.report(f"by a fake: {share:.0f} %", share)
        if at_s > timeout_s:
            raise StoppedError(ErrorCode.TIMEOUT, f"not done within {timeout_s:g} s")

    def hang(self) -> None:
        """Wait for a cancel, whatever the timeout."""
        self._wait(math.inf)

    def _wait(self, seconds: float) -> None:
        if self._running.is_cancelled_within(seconds):
            raise StoppedError(ErrorCode.PREEMPTED, "cancelled; the arm stopped")


# Between messages and the values of a fake cell's world


def panel_from(message: remodel_msgs.Panel) -> Panel:
    """Return the panel of a message.

    Raises:
        ValueError: with every name that is used and not there.
    """
    places, openings = {}, {}
    for component in message.components:
        pose = component.pose
        places[component.id] = (pose.x, pose.y, 0.0, pose.theta)
        for terminal in component.terminals:
            openings[f"{component.id}/{terminal.id}"] = _opening(places[component.id], terminal)
    wires = {
        wire.id: (f"{wire.a_component}/{wire.a_terminal}", f"{wire.b_component}/{wire.b_terminal}")
        for wire in message.wires
    }
    missing = [
        f"wire {wire!r} goes to {terminal!r}, which is not there"
        for wire, terminals in wires.items()
        for terminal in terminals
        if terminal not in openings
    ]
    if missing:
        raise ValueError("; ".join(missing))
    return Panel(
        message.name,
        wires,
        {wire.id: wire.length for wire in message.wires},
        places,
        openings=openings,
        channels=tuple(channel.id for channel in message.channels),
        ducts={wire.id: tuple(wire.ducts) for wire in message.wires if wire.ducts},
        serial=message.serial,
    )


def result_fields(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return what an ability found out as fields of its result message."""
    fields = dict(found)
    if "observation" in fields:
        fields["observation"] = _observation(*fields["observation"])
    return {
        n: panel_pose(value) if isinstance(value, tuple) else value for n, value in fields.items()
    }


def truth_of(world: World, wire: str) -> WireTruth:
    """Return where a wire is."""
    truth = WireTruth(wire_id=wire, placed=world.is_placed(wire))
    for end in "ab":
        seat = world.seat(wire, end)
        if seat is not None:
            setattr(truth, f"{end}_at", seat.terminal)
            setattr(truth, f"{end}_fixed", seat.fixed)
    return truth


def _opening(component: Place, terminal: remodel_msgs.Terminal) -> Place:
    x, y, _, yaw = component
    opening = terminal.mouth
    return (
        x + opening.x * math.cos(yaw) - opening.y * math.sin(yaw),
        y + opening.x * math.sin(yaw) + opening.y * math.cos(yaw),
        opening.z,
        yaw + terminal.insertion_yaw,
    )


def _observation(cable_id: str, length_m: float, loose_ends: int) -> CableObservation:
    tips = [panel_pose((0.0, 0.0, 0.0, 0.0)) for _ in range(loose_ends)]
    return CableObservation(
        cable_id=cable_id,
        centreline=[],
        tips=tips,
        length=length_m,
        confidence=1.0,
        truncated=False,
    )


# One goal at a time for a robot whose abilities are served by several processes


class RobotLock:
    """A lock on a file; the system frees it when the process that holds it dies."""

    def __init__(self, path: str) -> None:
        """Name the file; it is made when it is needed."""
        self._path = path
        self._file: int | None = None

    def take(self) -> bool:
        """Return whether the lock was free, and is now held."""
        file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            return False
        self._file = file
        return True

    def free(self) -> None:
        """Release it, if it is held."""
        file, self._file = self._file, None
        if file is not None:
            os.close(file)


# An ability whose answers are scripted, and given at once or never


@dataclass(frozen=True)
class FakeAnswer:
    """How a fake ability answers one goal.

    Attributes:
        error_code: 0 succeeds, another code aborts with it.
        refuse: reject the goal instead.
        hang: never answer; the goal ends only when it is cancelled.
        contradict: say success in the result, whatever the code.
        elapsed_s: [s] elapsed_time of the result.
    """

    error_code: int = ErrorCode.NONE
    refuse: bool = False
    hang: bool = False
    contradict: bool = False
    elapsed_s: float = 0.1


class FakeAbility(AbilityServer):
    """A server that answers one goal after the other at once; the last answer is repeated."""

    def __init__(
        self,
        ability: str | Ability,
        answers: Iterable[FakeAnswer] = (FakeAnswer(),),
        topic: str = "",
    ) -> None:
        """Start to serve an ability, on its usual topic unless another is given."""
        self._lock = threading.Lock()
        self.script(*answers)
        super().__init__(ability, topic=topic)

    def script(self, *answers: FakeAnswer) -> None:
        """Replace the answers to come and forget the goals that came."""
        with self._lock:
            self._answers = list(answers)
            self.goals: list[Message] = []
            self.cancelled: list[str] = []

    def prepare(self, goal: Message) -> FakeAnswer:
        """Return the next answer, unless it refuses the goal."""
        with self._lock:
            answer = self._answers.pop(0) if len(self._answers) > 1 else self._answers[0]
            self.goals.append(goal)
        if answer.refuse:
            code = answer.error_code or ErrorCode.INVALID_GOAL
            raise AbilityError(code, _reason(code))
        return answer

    def start(self, running: RunningGoal, prepared: FakeAnswer) -> None:
        """Answer."""
        if not prepared.hang:
            self.finish(running, lambda: self._answer(running, prepared))

    def cancel(self, running: RunningGoal) -> None:
        """End a goal that hangs."""
        with self._lock:
            self.cancelled.append(running.goal.id)
        self.finish(running, lambda: running.fail(ErrorCode.PREEMPTED, "cancelled", {}))

    def _answer(self, running: RunningGoal, answer: FakeAnswer) -> None:
        code, elapsed = answer.error_code, {"elapsed_time": answer.elapsed_s}
        if code == ErrorCode.NONE:
            running.succeed("done, by a fake", {**self.ability.fake, **elapsed})
        else:
            found = {**elapsed, "success": answer.contradict}
            running.fail(code, _reason(code), found)


def _reason(code: int) -> str:
    return f"scripted to answer error {code}"


def _are_codes(given: object) -> bool:
    """Return whether these are numbers of error codes, at least one."""
    return isinstance(given, list) and given != [] and all(type(code) is int for code in given)


def serve_all(
    codes: dict[str, list[int]], abilities: object = "", others: object = ""
) -> list[FakeAbility]:
    """Serve abilities.

    Args:
        codes: for some abilities, the error codes of successive goals; 0 succeeds.
        abilities: names of those to serve, see chosen_abilities; empty: all.
        others: names of those of them not to serve.

    Raises:
        ValueError: if one of them names no ability.
    """
    rows = read_abilities()
    if not isinstance(codes, dict) or not all(map(_are_codes, codes.values())):
        example = "{InsertCable: [301, 0]}"
        raise ValueError(f"codes are {codes!r}; allowed: numbers by abilities, such as {example}")
    unknown = sorted(set(codes) - set(rows))
    if unknown:
        raise ValueError(f"no such ability: {', '.join(unknown)}; there are {', '.join(rows)}")
    names = chosen_abilities(list(rows), abilities, others)
    fakes = [
        FakeAbility(rows[name], [FakeAnswer(code) for code in codes.get(name, [0])])
        for name in names
    ]
    rospy.loginfo("fake abilities serve: %s", ", ".join(names))
    return fakes
