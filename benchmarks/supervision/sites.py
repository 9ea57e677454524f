"""The two cells that the campaign runs on: how a fault is caused there, and what is true there."""

from __future__ import annotations

import threading
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Protocol

import rospy
from fast_clock import FastClock
from remodel_msgs.srv import InjectFault
from stack import Stack
from trial import Trial
from verdict import cell_s

from remodel_states.testing.world_file import WorldFile
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Event, TaskBegun
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.ros.peers.cell import Cell

HERE = Path(__file__).parent

# How much faster than the wall's the time of the fake cell passes.
_SPEED = 10.0

# [s] wall time between two checks whether a run has begun its first task.
_CHECK_S = 0.1


class Site(Protocol):
    """A cell.

    Attributes:
        launch: file that starts it, and all above it.
        nodes: that must be there.
        limit_s: [s] wall time after which a run counts as hung.
    """

    launch: Path
    nodes: tuple[str, ...]
    limit_s: float

    def arguments(self, output: Path) -> dict[str, object]:
        """Return arguments of the launch file, beside output and database."""

    def connect(self, nodes: Stack, log: RunLog) -> None:
        """Take the nodes that run, and the log of their runs."""

    def arm(self, trial: Trial) -> None:
        """See to it that the fault of a trial strikes in the run that begins next."""

    def has_struck(self, trial: Trial) -> bool:
        """Return whether it has."""

    def placed(self, wires: Collection[str]) -> set[str]:
        """Return which wires are where they belong."""

    def hand_is_empty(self) -> bool:
        """Return whether nothing is left in the hand, as far as the cell reports it."""

    def cell_s(self, events: Sequence[Event]) -> float:
        """Return how long a run takes in a cell [s], without what stands above it."""


class FakeSite:
    """The fake cell: faults at its interface, as quick as the processes above it allow."""

    launch = HERE / "campaign.launch"
    nodes = ("fake_cell", "picker", "use_case_supervisor", "behavior_action_server")
    limit_s = 120.0

    def __init__(self, durations_s: Mapping[str, float], inspection_s: float) -> None:
        """Take how long operations, by ability, and an inspection take in a true cell [s]."""
        self._durations_s = durations_s
        self._inspection_s = inspection_s

    def arguments(self, output: Path) -> dict[str, object]:
        """Return the file of the world."""
        return {"world": output / "world.sqlite"}

    def connect(self, nodes: Stack, _: RunLog) -> None:
        """Be the clock."""
        FastClock(_SPEED)
        self._world = WorldFile(nodes.output / "world.sqlite")

    def arm(self, trial: Trial) -> None:
        """Set the cell's faults, which it reads when the panel is loaded."""
        rospy.set_param("fake_cell/faults", list(trial.faults))

    def has_struck(self, trial: Trial) -> bool:
        """Return whether a goal was struck."""
        return any(f.struck for f in self._world.read().faults if f.name == trial.kind)

    def placed(self, wires: Collection[str]) -> set[str]:
        """Return which wires are fixed at both ends."""
        world = self._world.read().world
        return {name for name in wires if world.is_placed(name)}

    def hand_is_empty(self) -> bool:
        """Return whether nothing is held."""
        return not any(hands.held for hands in self._world.read().world.hands.values())

    def cell_s(self, events: Sequence[Event]) -> float:
        """Return what the operations would take in a true cell."""
        return cell_s(events, self._durations_s, self._inspection_s)


class SimulatedSite:
    """The PyBullet cell: faults by their physical causes, once the first wire of a run is fed."""

    launch = HERE.parents[1] / "src" / "remodel_planner" / "launch" / "order.launch"
    nodes = ("cell", "use_case_supervisor", "behavior_action_server")
    limit_s = 1800.0

    def arguments(self, _: Path) -> dict[str, object]:
        """Return none."""
        return {}

    def connect(self, _: Stack, log: RunLog) -> None:
        """Take the log, which shows when a run has begun."""
        self._log = log
        self._cell = Cell()
        self._struck = threading.Event()
        self._armed = threading.Event()

    def arm(self, trial: Trial) -> None:
        """Begin to wait for the run's first behavior; its wire is fed by then."""
        self._armed.clear()  # the waiting of the trial before is over
        self._struck, self._armed = threading.Event(), threading.Event()
        self._armed.set()
        if trial.kind:
            arguments = (trial, self._struck, self._armed)
            threading.Thread(target=self._strike, args=arguments, daemon=True).start()

    def has_struck(self, _: Trial) -> bool:
        """Return whether the cell has caused it."""
        return self._struck.is_set()

    def placed(self, wires: Collection[str]) -> set[str]:
        """Return which wires are fixed where they belong, by the cell's ground truth."""
        return {name for name in wires if self._cell.placed(name)}

    def hand_is_empty(self) -> bool:
        """Return true: the cell does not report what it holds."""
        return True

    def cell_s(self, events: Sequence[Event]) -> float:
        """Return the simulated time of all behaviors."""
        return state_after(events).cell_s

    def _strike(self, trial: Trial, struck: threading.Event, armed: threading.Event) -> None:
        fault = trial.faults[0]
        never = threading.Event()
        while armed.is_set() and not rospy.is_shutdown():
            run = self._log.unfinished("cell")
            begun = run is not None and any(
                isinstance(kept.event, TaskBegun) for kept in self._log.events(run)
            )
            if begun:
                inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
                answer = inject(fault["kind"], fault["target"], fault["values"])
                if not answer.success:
                    rospy.logerr("fault %s: %s", fault, answer.message)
                elif armed.is_set():
                    struck.set()
                return
            never.wait(_CHECK_S)
