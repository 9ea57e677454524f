"""The cell in one process: the time it makes, and its panel, feeder, score and pictures as ports.

Everything else waits in the cell's time. Nothing reads a wall clock, and nothing has a thread of
its own: what happens follows from the order and the seed alone. While an ability runs, time passes
by the ticks of the physics; while nothing runs, it is set to when something is due next.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import cv2
import rospy
from remodel_msgs.msg import Panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.ros.owner import Owner
from remodel_states.core.codes import Code
from remodel_states.core.wires import WireMaterials
from remodel_supervision.errors import RefusedError
from remodel_tasks.core.task_charts.planned_tasks import Demands
from remodel_work.errors import AbilityError, CellError, PanelError
from remodel_work.ros.panel_message import panel_from
from remodel_work.routes import PlacedWires


class StuckError(Exception):
    """Everything waits, and nothing will ever happen."""


class CellClock:
    """The cell's time, which is ROS's in this process.

    Attributes:
        now_s: [s] since the beginning, which is second 1: zero means "no time yet" in ROS.
    """

    def __init__(self) -> None:
        """Begin, and have rospy use this time: without a node it has none of its own."""
        self.now_s = 1.0
        rospy.rostime.set_rostime_initialized(True)
        self._tell()

    @property
    def now(self) -> rospy.Time:
        """The time as messages have it."""
        return rospy.Time.from_sec(self.now_s)

    def advance(self, seconds: float) -> None:
        """Let time pass [s]."""
        self.now_s += seconds
        self._tell()

    def idle(self) -> None:
        """Nothing passes by itself."""

    def close(self) -> None:
        """Have rospy be without a time again, as before."""
        rospy.rostime._rostime_current = None
        rospy.rostime.set_rostime_initialized(False)

    def _tell(self) -> None:
        rospy.rostime._rostime_current = self.now


class Part(Protocol):
    """What takes its turn in the loop."""

    def turn(self) -> bool:
        """Do what is due; return whether there was anything."""

    def next_due_s(self) -> float:
        """Return when [s] something is due although nothing else happens; infinity if never."""


class _Timer:
    """A call that is repeated."""

    def __init__(self, due_s: float, period_s: float, call: Callable[[], None]) -> None:
        self.due_s, self.period_s, self.call = due_s, period_s, call

    def cancel(self) -> None:
        """Call it no more."""
        self.due_s = math.inf


class CellLoop:
    """The event loop of a supervisor, by the cell's time; see supervisors.ports.EventLoop.

    Attributes:
        parts: those that take turns, in this order.
        is_leaving: never.
    """

    is_leaving = False

    def __init__(self, clock: CellClock) -> None:
        """Begin without parts."""
        self.parts: list[Part] = []
        self._clock = clock
        self._timers: list[_Timer] = []

    def now_s(self) -> float:
        """Return the cell's time [s]."""
        return self._clock.now_s

    def wall_s(self) -> float:
        """Return the cell's time [s]: it is the only one."""
        return self._clock.now_s

    def run_until(
        self, holds: Callable[[], bool], limit_s: float, *, while_leaving: bool = False
    ) -> bool:
        """Let the parts take turns until a condition holds, or a limit of time [s] has passed.

        Raises:
            StuckError: if there is no limit, and nothing will ever happen.
        """
        end_s = self._clock.now_s + limit_s
        while True:
            self._fire()
            if holds():
                return True
            if self._clock.now_s >= end_s:
                return False
            if not any(part.turn() for part in self.parts):
                self._pass_to(min(end_s, self._next_due_s()))

    def every(self, period_s: float, call: Callable[[], None]) -> _Timer:
        """Have something called again and again, each period [s]."""
        timer = _Timer(self._clock.now_s + period_s, period_s, call)
        self._timers.append(timer)
        return timer

    def _fire(self) -> None:
        now_s = self._clock.now_s
        self._timers = [timer for timer in self._timers if timer.due_s < math.inf]
        for timer in tuple(self._timers):
            if timer.due_s <= now_s:
                timer.due_s = now_s + timer.period_s
                timer.call()

    def _next_due_s(self) -> float:
        timers = (timer.due_s for timer in self._timers)
        parts = (part.next_due_s() for part in self.parts)
        return min((*timers, *parts), default=math.inf)

    def _pass_to(self, at_s: float) -> None:
        if at_s == math.inf:
            raise StuckError("everything waits, and nothing is due")
        if at_s > self._clock.now_s:
            self._clock.advance(at_s - self._clock.now_s)


class CellServices:
    """The services of the simulated cell; the supervisor's port, and a part of the loop.

    Attributes:
        cpu_s: CPU time in physics, vision and skills so far [s].
    """

    def __init__(
        self,
        owner: Owner,
        plant: SimulatedPlant,
        materials: WireMaterials,
        placed: PlacedWires,
        disturb: Callable[[SimulatedPlant], None],
    ) -> None:
        """Take a cell.

        Args:
            owner: runs it.
            plant: of it.
            materials: complete the wires of a panel.
            placed: the wires that lie on the panel before the order begins.
            disturb: is called when the panel is built, before anything is observed.
        """
        self._owner, self._plant, self._materials = owner, plant, materials
        self._placed, self._disturb = placed, disturb
        self.cpu_s = 0.0

    def wait(self, limit_s: float) -> None:
        """They are there."""

    def address(self) -> str:
        """Return where the cell answers."""
        return "this process"

    def load(self, panel: object, serial: str, owner: int, *, demands: Demands, keep: bool) -> None:
        """Build a panel, with the wires that lie on it; RefusedError if the cell cannot."""
        assert isinstance(panel, Panel)
        panel.serial = serial

        def build() -> None:
            self._owner.cell.admit(owner)
            self._owner.cell.load(
                panel_from(panel, self._materials),
                robots=demands.robots,
                forces_n=dict(demands.forces_n),
                placed=self._placed,
            )

        self._do(build, f"load panel {panel.name}")
        self._disturb(self._plant)

    def feed(self, wire: str, owner: int) -> None:
        """Present a piece of a wire; RefusedError if the feeder cannot."""

        def feed() -> None:
            self._owner.cell.admit(owner)
            self._owner.cell.feed(wire, "")

        self._do(feed, f"feed wire {wire}")

    def take_over(self, owner: int) -> bool:
        """Return that nothing moves: no other supervisor has been here."""
        return True

    def placed(self, wire: str) -> bool | None:
        """Return whether a wire is placed, by ground truth; None if there is none of it."""
        if wire not in self._plant.shapes():
            return None
        (truth,) = ground_truth(self._plant, [wire])
        return truth.placed

    # --- part of the loop

    def turn(self) -> bool:
        """Let one tick of the cell pass if an ability runs."""
        with self._timed():
            return self._owner.turn()

    def next_due_s(self) -> float:
        """Return never: between goals the scene is frozen."""
        return float("inf")

    def _do(self, action: Callable[[], None], what: str) -> None:
        """Do something in the cell; RefusedError, as its services answer."""
        try:
            with self._timed():
                action()
        except AbilityError as error:
            raise RefusedError(int(error.code), f"cannot {what}: {error}") from error
        except PanelError as error:
            raise RefusedError(int(Code.INVALID_GOAL), f"cannot {what}: {error}") from error
        except CellError as error:
            raise RefusedError(int(Code.INTERNAL), f"cannot {what}: {error}") from error

    @contextmanager
    def _timed(self) -> Iterator[None]:
        began_s = time.process_time()
        try:
            yield
        finally:
            self.cpu_s += time.process_time() - began_s


class FailurePictures:
    """Pictures of the scene when a behavior has failed; the supervisor's port `Pictures`.

    Attributes:
        kept: files, by the labels of behaviors.
    """

    def __init__(self, plant: SimulatedPlant, folder: Path | None) -> None:
        """Keep pictures in a folder; None: none."""
        self.kept: dict[str, Path] = {}
        self._plant, self._folder = plant, folder

    def begin(self) -> None:
        """Forget nothing."""

    def keep(self, run: int, label: str) -> tuple[str, ...]:
        """Take a picture of the scene, unless the wire has its place."""
        if self._folder is None or self._plant.live is None:
            return ()
        file = self._folder / f"{label}.png"
        picture = self._plant.photograph("scene").rgb
        cv2.imwrite(str(file), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
        self.kept[label] = file
        return (file.name,)
