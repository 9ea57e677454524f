"""A cell without ROS: its plant, and the robot contexts that the abilities use.

Who may command it: a supervisor that acquires the cell gets a token greater than all before. It
puts the token in front of the id of each goal ("17:insert a") and into the requests of services.
The cell refuses a token older than the newest it has seen, so a supervisor that lost the cell while
it was stopped moves nothing when it continues. A goal without a token is not checked.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TypeVar

from remodel_skills.belief_state import NO_CHANNEL, BeliefState, EndState, Feed
from remodel_skills.device import Plant
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.edge.collision_check import BulletCollisionCheck
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.goal_checks import check_hands_empty, check_not_in_cell, find_demand_problems
from remodel_skills.robot_context import Observers, RobotContext, Steps, occupy, run
from remodel_skills.space import Traffic
from remodel_states.core.codes import Code
from remodel_states.core.contract import NO_OWNER
from remodel_work.errors import AbilityError, PanelError
from remodel_work.panel import Panel
from remodel_work.routes import PlacedWires

T = TypeVar("T")


class Cell:
    """One cell with one panel; what an operator and a feeder can do with it.

    Attributes:
        plant: the physical side, simulated or real.
        contexts: what abilities see of it, for each robot by its name.
    """

    def __init__(
        self,
        plant: Plant,
        *,
        observers: Observers | None = None,
        memory: CellMemory | None = None,
    ) -> None:
        """Take over a cell that holds a panel.

        `memory` keeps the wires that have their place for the next cell; None: they are lost.
        """
        self.plant = plant
        self._observers = observers or Observers()
        self._memory = memory
        self._newest_owner = memory.owner if memory else NO_OWNER
        self._checks = {
            robot.name: BulletCollisionCheck(robot.arm, robot.clearance)
            for robot in plant.design.robots
            if robot.clearance is not None
        }
        self.contexts = self._make_contexts()
        if memory is not None:
            placed = memory.placed(self._held(plant.loaded))
            if placed.parked:
                self._load(plant.loaded, placed)

    def _make_contexts(self) -> dict[str, RobotContext]:
        """Return new stations for the robots of a freshly built plant."""
        first = self.plant.design.robots[0]
        parameters = read_parameters().parameters
        belief = BeliefState(first.name, first.arm)
        traffic = Traffic(parameters.motion.robots_apart_m)
        robots: dict[str, RobotContext] = {}
        for robot in self.plant.design.robots:
            own = belief if robot is first else belief.beside(robot.name, robot.arm)
            robots[robot.name] = RobotContext(
                self.plant.device_of(robot.name),
                self.plant.design,
                robot,
                self.plant.panel,
                own,
                robots,
                traffic=traffic,
                observers=self._observers,
                parameters=parameters,
                check=self._checks.get(robot.name),
            )
        return robots

    @property
    def context(self) -> RobotContext:
        """The first robot's."""
        return next(iter(self.contexts.values()))

    def context_of(self, robot: str) -> RobotContext:
        """Return a robot's context; raises UNKNOWN_NAME."""
        if robot not in self.contexts:
            there_are = ", ".join(self.contexts)
            raise AbilityError(Code.UNKNOWN_NAME, f"no robot {robot!r}; there are: {there_are}")
        return self.contexts[robot]

    def admit(self, owner: int) -> None:
        """Admit the client that holds an owner's token; NO_OWNER is always admitted.

        Raises STALE_OWNER when the cell has seen a newer token.
        """
        check_owner(owner, self._newest_owner)
        if owner > self._newest_owner:
            if self._memory is not None:
                self._memory.keep_owner(owner)
            self._newest_owner = owner

    def load(
        self,
        panel: Panel,
        *,
        robots: Collection[str] = (),
        forces_n: Mapping[str, float] = MappingProxyType({}),
        keep: bool = False,
        placed: PlacedWires | None = None,
    ) -> None:
        """Build a panel.

        Args:
            panel: to build.
            robots: that goals of its order name.
            forces_n: the greatest force limit [N] of these goals, by the ability.
            keep: leave the cell as it is if it has this very panel, of this serial number, already;
                a cell that was restarted puts back what it remembers of it.
            placed: the wires that lie on it; None: none, or those that the cell remembers.

        Raises:
            PanelError: if the panel breaks the rules, or the robots cannot do such goals; nothing
                changes.
        """
        tool = self.context.parameters.tool
        demanded = tuple(find_demand_problems(robots, forces_n, self.contexts, tool))
        if demanded:
            raise PanelError(panel.name, (*demanded, *self.plant.find_problems(panel)))
        if keep and panel == self.plant.loaded:
            return
        if placed is None:
            placed = PlacedWires()
            if keep and self._memory is not None:
                placed = self._memory.placed(self._held(panel))
        self._load(panel, placed)
        self.keep()

    def _held(self, panel: Panel) -> Panel:
        """Return a panel where this cell holds it: wires of elsewhere are not put back."""
        return replace(panel, world_from_panel=self.plant.design.world_from_panel)

    def _load(self, panel: Panel, placed: PlacedWires) -> None:
        self.plant.load(panel, placed.parked)
        self.contexts = self._make_contexts()
        self.context.belief.restore(placed)

    def keep(self) -> None:
        """Keep the wires that have their place, the live one too if it is finished.

        Raises MemoryFileError when there is a memory and it cannot be written to.
        """
        if self._memory is None:
            return
        parked = self.plant.shapes()
        if not self._is_finished():
            parked.pop(self._live or "", None)
        occupied = {
            terminal: held
            for terminal, held in self.context.belief.occupied.items()
            if held[0] in parked
        }
        self._memory.keep(self._held(self.plant.loaded), PlacedWires(parked, occupied))

    @property
    def _live(self) -> str | None:
        """The wire that is handled; None: there is none."""
        feed, magazine = self.context.belief.feed, self.context.device.magazine
        return feed.wire_id if feed and magazine.is_at_hand(feed.wire_id) else None

    def _is_finished(self) -> bool:
        """Return whether both ends of the live wire are fixed, and no hand holds it."""
        belief = self.context.belief
        fixed = bool(belief.ends) and all(state is EndState.FIXED for state in belief.ends.values())
        return fixed and not belief.hands

    def feed(self, wire_id: str, channel_id: str) -> None:
        """Present a new piece of a wire, unless an untouched one waits there.

        The feeder lays it into a channel; a cell with a magazine needs none.

        Raises AbilityError when a name is unknown, a hand holds a wire, or another piece of the
        wire is in the cell.
        """
        self.plant.panel.wire(wire_id)
        if self.plant.design.magazine is not None:
            channel_id = NO_CHANNEL
        else:
            self.plant.panel.channel(channel_id)
        belief = self.context.belief
        check_hands_empty(belief)
        if belief.presents(wire_id, channel_id):
            return
        check_not_in_cell(wire_id, belief)
        leaves_wire = self._live is not None
        tools = {name: context.commanded for name, context in self.contexts.items()}
        presentation = self.plant.feed(wire_id, channel_id, tools)
        expected = {end: tip.position for end, tip in presentation.tips.items()}
        for context in self.contexts.values():
            context.arm_restarted()
            context.belief.start_wire(Feed(wire_id, channel_id, presentation.direction), expected)
        if leaves_wire:
            self.keep()

    def run(self, steps: Steps[T], *robots: str) -> T:
        """Run an ability of some robots, the first by default; raises what it raises."""
        contexts = [self.contexts[robot] for robot in robots] or [self.context]
        try:
            return run(self.plant.tick, occupy(contexts, steps))
        finally:
            self.come_to_rest()

    def come_to_rest(self) -> None:
        """Let the scene come to rest after an ability, however it ended.

        The live wire is parked if both its ends are fixed and no hand holds it.
        """
        self.plant.rest(self.context.parameters.motion.force_still_s)
        if self._is_finished():
            self.plant.park()
            self.keep()

    def close(self) -> None:
        """Leave the cell."""
        for check in self._checks.values():
            check.close()
        self.plant.close()


def check_owner(owner: int, newest: int) -> None:
    """Raise STALE_OWNER when a token is older than the newest that the cell has seen."""
    if owner != NO_OWNER and owner < newest:
        raise AbilityError(
            Code.STALE_OWNER,
            f"owner {owner} no longer owns this cell, owner {newest} does; stop the older "
            "supervisor, or reset the cell's memory if the database was replaced",
        )
