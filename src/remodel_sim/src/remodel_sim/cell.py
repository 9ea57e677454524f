"""A cell without ROS: the plant, and the robot contexts that the abilities use."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TypeVar

from remodel_sim.core.cell.ownership import check_owner
from remodel_sim.edge.cell_file import read_cell
from remodel_sim.edge.cell_memory import CellMemory
from remodel_sim.physics.device import device_of
from remodel_sim.physics.plant import Plant
from remodel_skills.belief_state import NO_CHANNEL, BeliefState, EndState, Feed
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.goal_checks import check_hands_empty, check_not_in_cell
from remodel_skills.goals import find_demand_problems
from remodel_skills.observers import Observers
from remodel_skills.robot_context import RobotContext, Steps
from remodel_skills.runner import occupy, run
from remodel_skills.traffic import Traffic
from remodel_states.core.codes import Code
from remodel_states.core.goal_owner import NO_OWNER
from remodel_work.cell.cell_design import CellDesign
from remodel_work.errors import AbilityError, PanelError
from remodel_work.panel import Panel
from remodel_work.placed_wires import PlacedWires

T = TypeVar("T")

# An arm that was stopped, and the wire in its hand, come to rest in this time [s].
REST_S = 0.15


class Cell:
    """One cell with one panel; what an operator and a feeder can do with it.

    Attributes:
        plant: the physical side.
        contexts: what abilities see of it, for each robot by its name.
    """

    def __init__(
        self,
        panel: Panel,
        *,
        design: CellDesign | None = None,
        seed: int = 0,
        rate_hz: float = 240.0,
        gui: bool = False,
        observers: Observers | None = None,
        memory: CellMemory | None = None,
    ) -> None:
        """Build a cell, one Panda unless a design is given, see Plant; raises PanelError.

        `memory` keeps the wires that have their place for the next cell; None: they are lost.
        """
        self.plant = Plant(design or read_cell(), panel, seed=seed, rate_hz=rate_hz, gui=gui)
        self._observers = observers or Observers()
        self._memory = memory
        self._newest_owner = memory.owner if memory else NO_OWNER
        self.contexts = self._make_contexts()
        if memory is not None:
            self._restore(memory.placed(self._held(panel)))

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
                device_of(self.plant, robot),
                self.plant.design,
                robot,
                self.plant.panel,
                own,
                robots,
                traffic=traffic,
                observers=self._observers,
                parameters=parameters,
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
    ) -> None:
        """Build a panel.

        Args:
            panel: to build.
            robots: that goals of its order name.
            forces_n: the greatest force limit [N] of these goals, by the ability.
            keep: leave the cell as it is if it has this very panel, of this serial number, already;
                a cell that was restarted puts back what it remembers of it.

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
        placed = self._memory.placed(self._held(panel)) if keep and self._memory else PlacedWires()
        self.plant.load(panel)
        self.contexts = self._make_contexts()
        self._restore(placed)
        self.keep()

    def _held(self, panel: Panel) -> Panel:
        """Return a panel where this cell holds it: wires of elsewhere are not put back."""
        return replace(panel, world_from_panel=self.plant.design.world_from_panel)

    def _restore(self, placed: PlacedWires) -> None:
        if placed.parked:
            self.plant.restore(placed.parked)
            self.contexts = self._make_contexts()
            self.context.belief.restore(placed)

    def keep(self) -> None:
        """Keep the wires that have their place, the live one too if it is finished.

        Raises MemoryFileError when there is a memory and it cannot be written to.
        """
        if self._memory is None:
            return
        parked = dict(self.plant.parked)
        if self.plant.live is not None and self._is_finished():
            parked[self.plant.live.wire.id] = self.plant.live.shape
        occupied = {
            terminal: held
            for terminal, held in self.context.belief.occupied.items()
            if held[0] in parked
        }
        self._memory.keep(self._held(self.plant.loaded), PlacedWires(parked, occupied))

    def _is_finished(self) -> bool:
        """Return whether both ends of the live wire are fixed, and no hand holds it."""
        belief = self.context.belief
        fixed = bool(belief.ends) and all(state is EndState.FIXED for state in belief.ends.values())
        return fixed and not belief.hands

    def reset(self) -> None:
        """Rebuild the panel without any wire."""
        self.load(self.plant.loaded)

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
        leaves_wire = self.plant.live is not None
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
        """Let the scene come to rest after an ability, however it ended."""
        for _ in self.rest_steps():
            pass

    def rest_steps(self) -> Iterator[float]:
        """Let the scene come to rest, step by step; yield the time that each step took [s].

        At the end the live wire is parked if both its ends are fixed and no hand holds it.
        """
        time_step = self.plant.world.time_step
        for _ in range(round(REST_S / time_step)):
            self.plant.step()
            yield time_step
        if self._is_finished():
            self.plant.park()
            self.keep()

    def close(self) -> None:
        """Leave PyBullet."""
        self.plant.close()
