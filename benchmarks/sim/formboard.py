#!/usr/bin/env python3
"""Lay a harness's wires on a formboard with two robots, without ROS, and compare with the truth.

formboard.py [WIRE...] [--seed 1] [--cell two_arms_formboard] [--pictures DIR]; the workspace must
be sourced; all wires by default. Each wire of the example harness is placed as the use case
harness_formboard does it: robot_1 inserts the first end, robot_2 takes the other one, lets the wire
down into the forks, inserts it, and checks the forks. An action that fails is tried again, up to so
often as there; a wire that is not placed is discarded and fed again, up to `--pieces` times. A line
is printed for each step: wall time, the cell's time since the feed, and what was measured; of
components located, how far from the truth; where the wire passes its forks. The robots and cameras
decide whether a wire is placed; the last lines compare that with the truth. Ends with 1 if a wire
is not placed.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.ability import Goal
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.abilities.inserting import FixGoal, InsertGoal, fix_cable, insert_cable
from remodel_skills.abilities.inspection import (
    ComponentLocated,
    LocateGoal,
    locate_gearbox_component,
)
from remodel_skills.abilities.picking import (
    DetectGoal,
    PickGoal,
    PlaceGoal,
    detect_cable,
    pick_cable,
    place_cable,
)
from remodel_skills.abilities.route_wire import RouteGoal, route_wire
from remodel_skills.cell import Cell
from remodel_skills.robot_context import Image, Observers, OnObservation, RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.camera import Picture
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, PanelWire, WireEnd
from remodel_work.ros.panel_message import read_panel

CONFIG = Path(__file__).parents[2] / "src" / "remodel_sim" / "config"
FIRST, SECOND = "robot_1", "robot_2"
# As the use case harness_formboard.
FORCE_LIMIT_N, PULL_TEST_N, CARRY_Z = 8.0, 5.0, 0.06

G = TypeVar("G", bound=Goal)
T = TypeVar("T")


class Trial:
    """Places wires in one cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.failed = 0
        self.at_first: list[str] = []
        self._began = time.monotonic()

    def place(self, wire_id: str) -> None:
        """Place a wire, end a first; raises what an ability raises."""
        wire = self.cell.plant.panel.wire(wire_id)
        first, second = WireEnd.A, WireEnd.B
        a, b = wire.goes_to(first), wire.goes_to(second)
        self.cell.feed(wire_id, "")
        self._detect(wire_id)
        at_a, at_b = self._locate(a), self._locate(b)
        grasp = PickGoal(FIRST, wire_id, first, 0.0)
        self._held(2, pick_cable, grasp)
        insert = InsertGoal(FIRST, wire_id, first, *a, at_a, FORCE_LIMIT_N)
        self._attempts(3, FIRST, insert_cable, insert)
        self._attempts(2, FIRST, fix_cable, FixGoal(FIRST, wire_id, *a, PULL_TEST_N))
        self._detect(wire_id)
        self._held(3, pick_cable, PickGoal(SECOND, wire_id, second, 0.0))
        path = _path(wire)
        self._attempts(2, SECOND, route_wire, RouteGoal(SECOND, wire_id, path))
        insert = InsertGoal(SECOND, wire_id, second, *b, at_b, FORCE_LIMIT_N)
        self._attempts(3, SECOND, insert_cable, insert)
        self._attempts(2, SECOND, fix_cable, FixGoal(SECOND, wire_id, *b, PULL_TEST_N))

    def give_up(self, wire_id: str) -> None:
        """Empty the hands, and discard the wire; raises what an ability raises."""
        for robot, context in self.cell.contexts.items():
            if context.belief.grip is not None:
                target = BOARD @ Pose.level(0.0, 0.0, CARRY_Z)
                with suppress(AbilityError):  # what has slipped out of the fingers is released
                    self._do(robot, place_cable, PlaceGoal(robot, wire_id, target))
        discard = DiscardGoal(FIRST, wire_id)
        self._attempts(2, FIRST, discard_cable, discard)

    def _detect(self, wire_id: str) -> None:
        self._attempts(3, FIRST, detect_cable, DetectGoal(wire_id))

    def _locate(self, key: tuple[str, str]) -> Pose:
        found = self._attempts(3, FIRST, locate_gearbox_component, LocateGoal(*key))
        assert found.socket_pose is not None
        return found.socket_pose

    def _held(
        self, times: int, ability: Callable[[RobotContext, G], Steps[T]], goal: PickGoal
    ) -> None:
        for attempt in range(times):
            try:
                self._do(goal.robot_name, ability, goal)
            except AbilityError as error:
                self._failed(goal, error)
                if attempt == times - 1:
                    raise
                self._detect(goal.cable_id)
            else:
                return

    def _attempts(
        self, times: int, robot: str, ability: Callable[[RobotContext, G], Steps[T]], goal: G
    ) -> T:
        for _ in range(times - 1):
            try:
                return self._do(robot, ability, goal)
            except AbilityError as error:
                if error.code is Code.OUT_OF_DUCT:  # a supervisor handles it first
                    raise
                self._failed(goal, error)
        return self._do(robot, ability, goal)

    def _failed(self, goal: Goal, error: AbilityError) -> None:
        self.failed += 1
        self._print(type(goal).__name__.removesuffix("Goal"), f"{error.code.name}: {error}")

    def _do(self, robot: str, ability: Callable[[RobotContext, G], Steps[T]], goal: G) -> T:
        context = self.cell.contexts[robot]
        goal.check(context.panel, context.belief, context.parameters)
        try:
            found = self.cell.run(ability(context, goal), robot)
            self._print(type(goal).__name__.removesuffix("Goal"), found)
        finally:
            self._print_truth()
        if isinstance(found, ComponentLocated):
            self._compare(goal.component_id, found)
        return found

    def _compare(self, component: str, found: ComponentLocated) -> None:
        true = self.cell.plant.world_from_component(component)
        off = true.inverse() @ found.component_pose
        tilt = math.degrees(math.acos(min(1.0, float(off.rotation[2, 2]))))
        x, y, z = off.position * 1e3
        _print_line(
            f"      {component}: {x:+.2f}, {y:+.2f}, {z:+.2f} mm, {math.degrees(off.yaw):+.2f} deg,"
            f" tilted {tilt:.2f} deg from the truth"
        )

    def _print_truth(self) -> None:
        """Print where the ends are, and where hands hold them."""
        plant = self.cell.plant
        if plant.live is None:
            return
        (truth,) = ground_truth(plant, [plant.live.wire.id])
        lines = [
            f"end {end.value} {found.depth * 1e3:.1f} mm deep in {found.at}"
            for end, found in zip(WireEnd, (truth.a, truth.b), strict=True)
            if found.at
        ]
        for name, context in self.cell.contexts.items():
            grip = context.belief.grip
            if grip is None:
                continue
            tip, out = plant.live.cable.tip(grip.end)
            tool = context.device.arm.tool
            yaw = tool.yaw + grip.flip
            along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
            off = tip - tool.position
            aside = float(off @ [-along[1], along[0], 0.0])
            lines.append(
                f"{name} holds end {grip.end.value} {off @ along * 1e3:.1f} mm behind its tip"
                f" (believed {grip.distance * 1e3:.1f}), tip {aside * 1e3:+.1f} mm aside,"
                f" {off[2] * 1e3:+.1f} mm up (believed {grip.height * 1e3:+.1f}), it rises by"
                f" {math.degrees(math.asin(out[2])):+.1f} deg"
            )
        lines.append(_passings(plant, plant.live.wire.id))
        for line in lines:
            _print_line(f"      {line}")

    def _print(self, step: str, found: object) -> None:
        message = getattr(found, "message", found)
        wall, world = time.monotonic() - self._began, self.cell.plant.world
        cell = world.steps * world.time_step
        _print_line(f"{wall:6.1f} s  {cell:6.1f} s  {step}: {message}")


def _passings(plant: SimulatedPlant, wire_id: str) -> str:
    """Return where a wire that was fed passes its forks."""
    live = plant.live is not None and plant.live.wire.id == wire_id
    nodes = plant.live.cable.nodes() if live else plant.parked[wire_id].nodes
    texts = []
    for fork in plant.panel.ducts:
        x, y, z = (BOARD @ fork.panel_from_duct).inverse().apply(nodes).T
        for i in np.flatnonzero(x[:-1] * x[1:] < 0):
            share = x[i] / (x[i] - x[i + 1])
            aside, height = (1e3 * (v[i] + share * (v[i + 1] - v[i])) for v in (y, z))
            texts.append(f"{fork.id} {aside:+.0f} mm aside, {height:.0f} mm high")
    return "; ".join(texts)


def _path(wire: PanelWire) -> tuple[Pose, ...]:
    """Return poses along a wire's route, at the height at which it is carried, world frame."""
    points = [np.array(point[:2]) for point in wire.route]
    yaws = [math.atan2(*(q - p)[::-1]) for p, q in itertools.pairwise(points)]
    at = zip(points, [*yaws, yaws[-1]], strict=True)
    return tuple(BOARD @ Pose.level(*p.tolist(), CARRY_Z, yaw) for p, yaw in at)


def _photograph(cell: Cell, folder: Path, name: str) -> None:
    for camera in ("scene", "overhead"):
        picture = cv2.cvtColor(cell.plant.photograph(camera).rgb, cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(folder / f"{name}_{camera}.png"), picture)


def _keep_in(folder: Path) -> OnObservation:
    """Return a callback that writes what was found in each picture into a folder."""
    number = itertools.count(1)

    def keep(camera: str, picture: Picture, drawn: Image | None) -> None:
        if drawn is not None:
            file = folder / f"{next(number):04}_{camera}.png"
            cv2.imwrite(str(file), cv2.cvtColor(drawn, cv2.COLOR_RGB2BGR))

    return keep


def _print_line(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> int:
    """Place the wires; return 0 if all are placed."""
    parser = argparse.ArgumentParser(description="Lay a harness's wires on a formboard.")
    parser.add_argument("wires", nargs="*", metavar="WIRE", help="such as W1.3; default: all")
    parser.add_argument("--seed", type=int, default=1, help="of all noise")
    parser.add_argument("--pieces", type=int, default=1, help="of each wire that are tried")
    parser.add_argument("--cell", default="two_arms_formboard", help="name or file")
    parser.add_argument("--pictures", type=Path, help="folder for pictures, also those observed")
    options = parser.parse_args()
    if options.pictures is not None:
        options.pictures.mkdir(parents=True, exist_ok=True)
    panel = read_panel(CONFIG / "harness.yaml", read_wire_materials())
    observers = Observers(_keep_in(options.pictures)) if options.pictures else None
    design = read_cell(options.cell)
    cell = Cell(SimulatedPlant(panel, design=design, seed=options.seed), observers=observers)
    trial = Trial(cell)
    wires = options.wires or [wire.id for wire in panel.wires]
    placed = [wire for wire in wires if _is_placed(trial, wire, options.pieces, options.pictures)]
    truths = ground_truth(cell.plant, placed)
    for truth in truths:
        _print_line(f"{truth.wire_id}: {_passings(cell.plant, truth.wire_id)}")
    forks = len(panel.ducts)
    _print_line(
        f"{len(placed)} of {len(wires)} wires placed, {len(trial.at_first)} at the first attempt; "
        f"{trial.failed} failed operations; by the truth "
        f"{sum(truth.placed for truth in truths)} are placed, and "
        f"{sum(round(forks * truth.in_ducts) for truth in truths)} of their "
        f"{forks * len(truths)} forks hold them"
    )
    cell.close()
    return 0 if len(placed) == len(wires) else 1


def _is_placed(trial: Trial, wire_id: str, pieces: int, pictures: Path | None) -> bool:
    """Place a wire; return whether one of so many pieces was placed, by robots and cameras."""
    for piece in range(pieces):
        found = "placed"
        try:
            trial.place(wire_id)
        except AbilityError as error:
            found = f"{error.code.name}: {error}"
            trial.failed += 1
        (truth,) = ground_truth(trial.cell.plant, [wire_id])
        depths = ", ".join(f"{end.depth * 1e3:.1f} mm" for end in (truth.a, truth.b))
        _print_line(
            f"{wire_id}, piece {piece + 1}: {found}; by the truth "
            f"{'placed' if truth.placed else 'NOT PLACED'}, ends {depths} deep, "
            f"{truth.in_ducts:.0%} of its forks"
        )
        if pictures is not None:
            _photograph(trial.cell, pictures, f"{wire_id}_{piece + 1}")
        if found == "placed":
            if piece == 0:
                trial.at_first.append(wire_id)
            return True
        try:
            trial.give_up(wire_id)
        except AbilityError as error:
            _print_line(f"{wire_id}: not discarded: {error.code.name}: {error}")
            return False
    return False


if __name__ == "__main__":
    sys.exit(main())
