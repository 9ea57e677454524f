"""What a page shows of the live system, and which nodes are not running, for an operator."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from remodel_console.core.run.decision import Decisions
from remodel_console.core.run.run_view import Phase, RunView
from remodel_console.core.use_case.use_case import UseCase


@dataclass(frozen=True)
class Notice:
    """A node that is not running: what that means, and the command that starts it."""

    what: str
    meaning: str
    remedy: str


@dataclass(frozen=True)
class InputRequest:
    """A value that a state waits for; `number` counts the requests of this console."""

    number: int
    text: str


@dataclass(frozen=True)
class World:
    """Which nodes are running, and the run.

    Attributes:
        has_master: the ROS master answers.
        has_mirror: a mirror follows what runs.
        has_abilities: ability servers are there, of a cell or fake ones.
        has_cell: the cameras of a cell are there.
        is_simulated: nothing real moves: the cell can be reset, or no ability server is there.
        has_supervisor: a use case supervisor is there.
        use_case: what it published last; None before that, and when it is not running.
        inputs: values that states wait for, the oldest first.
        breakpoints: paths of states, as the engine names them, before whose end it asks.
        decisions: states of the running behavior in which an operator chooses the outcome.
    """

    run: RunView = field(default_factory=RunView)
    has_master: bool = False
    has_mirror: bool = False
    has_abilities: bool = False
    has_cell: bool = False
    is_simulated: bool = False
    has_supervisor: bool = False
    use_case: UseCase | None = None
    inputs: tuple[InputRequest, ...] = ()
    decisions: Decisions = field(default_factory=Decisions)
    breakpoints: frozenset[str] = frozenset()

    @property
    def has_engine(self) -> bool:
        """Return whether a behavior engine is running."""
        return self.run.phase is not Phase.AWAY


def notices(world: World) -> Iterator[Notice]:
    """Yield what is not running; of nodes that need each other, the first."""
    if not world.has_master:
        yield Notice(
            "ROS is not running",
            "the master does not answer, so the console cannot show or command the cell",
            "roscore",
        )
        return
    if not world.has_engine:
        yield Notice(
            "The engine is not running",
            "no behavior can run",
            "roslaunch flexbe_onboard behavior_onboard.launch",
        )
    elif not world.has_mirror:
        yield Notice(
            "The mirror is not running",
            "the active state of a supervised run is not known",
            "roslaunch flexbe_mirror behavior_mirror.launch",
        )
    if not world.has_cell:
        yield Notice(
            "The cell is not running",
            "ability servers answer without a cell, so nothing moves"
            if world.has_abilities
            else "no ability server answers, so states that move the robot will fail",
            "roslaunch remodel_sim cell.launch",
        )


def supervisor_notice(world: World) -> Iterator[Notice]:
    """Yield that the use case supervisor is not running, if ROS is."""
    if world.has_master and not world.has_supervisor:
        yield Notice(
            "The supervisor is not running",
            "no order can run, and the state of a running order is not known",
            "roslaunch remodel_planner supervision.launch output:=DIR database:=URL attended:=true",
        )
