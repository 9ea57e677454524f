#!/usr/bin/env python3
"""Measure how often the abilities succeed, or refuse rightly, over seeds, and how long it takes.

abilities.py [--seeds 0-99] [--trials NAME ...] [--rate HZ] [--jobs N] [--map FILE]; the workspace
must be sourced. Each trial builds a cell from a seed, tries one thing, and asks the truth for the
score. A seed gives a wire its curvature and the cameras their noise; wires of the example panel
take turns. Every push and pull is recorded, and compared with its force limit. A trial that goes
wrong is printed with its seed and code as it ends. Exits with 1 when a target is missed.

--map maps what InsertCable does by error of its goal, and writes the docs' table: the opening in
the goal lies off to the side and is turned about the vertical, as after a bad observation, and the
goal is not checked. Each cell is one insertion of end a in a cell of its own.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path

import numpy as np

# The panels, the abilities' goals and the record of forces are those of the unit tests.
sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_sim/test/unit"))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_work/test"))
from figures import Figure, report, report_table
from force_record import recorded
from panels import example
from place_wire import ROBOT, do, fix, insert, locate

from remodel_planner.commands.options.common import seeds
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth, lies_in
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.abilities.inserting import (
    ConnectGoal,
    InsertGoal,
    insert_cable,
    place_connector,
)
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.abilities.route_wire import RouteGoal, route_wire
from remodel_skills.cell import Cell
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, PanelWire, WireEnd
from remodel_work.routes import world_from_clip

# What the states of the charts ask for when the chart says nothing [N].
FORCE_LIMIT_N, PULL_TEST_N, MATING_LIMIT_N = 8.0, 5.0, 30.0
# Force limits of pushes, as many as are no multiple of the panel's wires [N].
LIMITS_N = (4.0, 6.0, 8.0, 11.0, 14.0, 18.0, 25.0)
# End b is carried to beside its terminal: so far beyond it along the channel, and so high [m].
BESIDE_M, CARRY_Z_M = 0.030, 0.040
# An end that was picked is off the plate by so much [m].
LIFTED_M = 0.010
# How far beside the opening a socket pose lies that is wrong and not corrected [m].
OFFSET_M = 0.006
# Changes under which components are located [m], [rad], share of the light.
SHIFT_M, TURN_RAD, LIGHT = 0.010, math.radians(8.0), (0.4, 1.6)
# A path over clips begins and ends so far from them, and runs so high [m].
BEYOND_CLIP_M, PATH_Z_M = 0.020, 0.050
WALL_S = 10.0
# Errors of goals in the map.
OFFSETS_MM = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
ANGLES_DEG = (0.0, 5.0, 10.0, 15.0, 20.0)


@dataclass(frozen=True)
class Outcome:
    """How one trial went.

    Attributes:
        good: whether it went as it should: success, or the refusal that was right.
        found: the code met with its message, or "NONE".
        figures: what else was measured, by name.
        pushes: of each push and pull under force control its limit, the largest force at the
            wrist, not filtered, and what is allowed [N].
    """

    good: bool
    found: str
    figures: dict[str, float] = field(default_factory=dict)
    pushes: tuple[tuple[float, float, float], ...] = ()


def place(cell: Cell, wire: PanelWire) -> Outcome:
    """Place a wire; good when both ends sit in closed terminals, by the truth."""
    wall, cpu = time.perf_counter(), time.process_time()
    found = code_of(lambda: place_whole(cell, wire))
    times = {"wall [s]": time.perf_counter() - wall, "cpu [s]": time.process_time() - cpu}
    (truth,) = ground_truth(cell.plant, [wire.id])
    seated = sum(end.seated and end.fixed for end in (truth.a, truth.b))
    return Outcome(truth.placed and is_none(found), found, {"ends": seated, **times})


def place_whole(cell: Cell, wire: PanelWire) -> None:
    """Feed a wire and place it as its chart does when nothing goes wrong."""
    feed(cell, wire)
    do(cell, detect_cable, DetectGoal(wire.id))
    connect(cell, wire, WireEnd.A)
    pick_end(cell, wire, WireEnd.B)
    panel, belief = cell.context.panel, cell.context.belief
    direction = belief.feed.direction
    lane = float(BOARD.position[0]) + panel.channel(channel_of(cell, wire)).x
    opening = BOARD @ panel.panel_from_socket(*wire.goes_to(WireEnd.B))
    beside = float(opening.position[1]) + BESIDE_M * direction
    target = Pose.level(lane, beside, CARRY_Z_M, direction * math.pi / 2)
    do(cell, route_wire, RouteGoal(ROBOT, wire.id, (target,)))
    connect(cell, wire, WireEnd.B)


def connect(cell: Cell, wire: PanelWire, end: WireEnd) -> None:
    """Locate an end's terminal, insert the end and fix it."""
    terminal = wire.goes_to(end)
    insert(cell, wire.id, end, *terminal, locate(cell, *terminal), FORCE_LIMIT_N)
    fix(cell, wire.id, *terminal, PULL_TEST_N)


def feed(cell: Cell, wire: PanelWire) -> None:
    """Lay a wire into the channel in front of end a's terminal."""
    cell.feed(wire.id, channel_of(cell, wire))


def channel_of(cell: Cell, wire: PanelWire) -> str:
    """Return the channel in front of end a's terminal."""
    panel = cell.context.panel
    return panel.channel_in_front_of(panel.panel_from_socket(*wire.goes_to(WireEnd.A)).position).id


def pick_end(cell: Cell, wire: PanelWire, end: WireEnd) -> None:
    """Grasp an end."""
    do(cell, pick_cable, PickGoal(ROBOT, wire.id, end, 0.0))


def pick(cell: Cell, wire: PanelWire) -> Outcome:
    """Pick end a; good when it is off the plate, by the truth."""
    feed(cell, wire)
    found = code_of(lambda: pick_end(cell, wire, WireEnd.A))
    return Outcome(float(cell.plant.live.cable.tip(WireEnd.A)[0][2]) > LIFTED_M, found)


def seat(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert end a; good when it is seated and holds, by the truth."""
    found = code_of(lambda: inserted(cell, wire))
    (truth,) = ground_truth(cell.plant, [wire.id])
    return Outcome(truth.a.seated and truth.a.fixed and is_none(found), found)


def offset(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert 6 mm beside the opening: the housing stops it."""
    side = OFFSET_M if cell.plant.seed % 4 < 2 else -OFFSET_M
    return refused(lambda: inserted(cell, wire, side), Code.INSERTION_MISALIGNED)


def blocked(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert into an opening with a plug in it."""
    cell.plant.block_socket(*wire.goes_to(WireEnd.A))
    return refused(lambda: inserted(cell, wire), Code.INSERTION_JAMMED)


def inserted(cell: Cell, wire: PanelWire, side: float = 0.0) -> None:
    """Feed a wire, locate the terminal or header of its end a, and push it there or aside [m]."""
    feed(cell, wire)
    target, own = wire.goes_to(WireEnd.A), wire.connector_at(WireEnd.A)
    socket = locate(cell, *target) @ Pose.level(0.0, side, 0.0)
    if own is None:
        insert(cell, wire.id, WireEnd.A, *target, socket, FORCE_LIMIT_N)
    else:
        goal = ConnectGoal(ROBOT, own.id, wire.id, *target, socket, MATING_LIMIT_N)
        do(cell, place_connector, goal)


def other_component(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert where end b's component is, under the name of end a's terminal."""
    feed(cell, wire)
    return inserted_elsewhere(cell, wire, locate(cell, *wire.goes_to(WireEnd.B)))


def neighbour(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert where the terminal beside end a's is, under the name of end a's."""
    component, own = wire.goes_to(WireEnd.A)
    others = [t.id for t in cell.context.panel.component(component).terminals if t.id != own]
    feed(cell, wire)
    socket = locate(cell, component, others[cell.plant.seed % len(others)])
    return inserted_elsewhere(cell, wire, socket)


def inserted_elsewhere(cell: Cell, wire: PanelWire, socket: Pose) -> Outcome:
    """Insert end a at a place that is another terminal's."""
    terminal = wire.goes_to(WireEnd.A)
    goal = (wire.id, WireEnd.A, *terminal, socket)
    return refused(lambda: insert(cell, *goal), Code.INVALID_GOAL)


def occupied(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert end b where end a sits."""
    terminal = wire.goes_to(WireEnd.A)
    feed(cell, wire)
    connect(cell, wire, WireEnd.A)
    socket = locate(cell, *terminal)
    goal = (wire.id, WireEnd.B, *terminal, socket)
    return refused(lambda: insert(cell, *goal), Code.TERMINAL_OCCUPIED)


def push(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert end a with each of the limits in turn; good when it is seated, by the truth."""
    found = code_of(lambda: pushed(cell, wire))
    (truth,) = ground_truth(cell.plant, [wire.id])
    return Outcome(truth.a.seated and is_none(found), found)


def push_blocked(cell: Cell, wire: PanelWire) -> Outcome:
    """The same with a plug in the terminal."""
    cell.plant.block_socket(*wire.goes_to(WireEnd.A))
    return refused(lambda: pushed(cell, wire), Code.INSERTION_JAMMED)


def pushed(cell: Cell, wire: PanelWire) -> None:
    """Insert end a with one of the limits."""
    terminal, limit_n = wire.goes_to(WireEnd.A), LIMITS_N[cell.plant.seed % len(LIMITS_N)]
    feed(cell, wire)
    socket = cell.plant.world_from_socket(*terminal)
    insert(cell, wire.id, WireEnd.A, *terminal, socket, limit_n)


def route(cell: Cell, wire: PanelWire) -> Outcome:
    """Lay a wire into the clips of the panel; good when it runs through all, by the truth."""
    panel = cell.context.panel
    feed(cell, wire)
    connect(cell, wire, WireEnd.A)
    pick_end(cell, wire, WireEnd.B)
    clips = [world_from_clip(clip, panel) for clip in panel.clips]
    before, after = (Pose.level(x, 0.0, 0.0) for x in (-BEYOND_CLIP_M, BEYOND_CLIP_M))
    ways = (clips[0] @ before, *clips, clips[-1] @ after)
    path = tuple(way @ Pose.level(0.0, 0.0, PATH_Z_M) for way in ways)
    found = code_of(lambda: do(cell, route_wire, RouteGoal(ROBOT, wire.id, path)))
    return Outcome(
        all(lies_in(cell.plant, wire.id, clip) for clip in panel.clips) and is_none(found), found
    )


def discard(cell: Cell, wire: PanelWire) -> Outcome:
    """Place a wire and discard it; good when none of it is left on the panel, by the truth.

    In every second trial only end a was placed, and b lies loose.
    """
    with suppress(AbilityError):
        if cell.plant.seed % 2:
            place_whole(cell, wire)
        else:
            feed(cell, wire)
            connect(cell, wire, WireEnd.A)
    found = code_of(lambda: do(cell, discard_cable, DiscardGoal(ROBOT, wire.id)))
    return Outcome(not ground_truth(cell.plant, [wire.id]) and is_none(found), found)


def located(disturb: Callable[[Cell, str], None]) -> Callable[[Cell, PanelWire], Outcome]:
    """Return the trial that locates a terminal after something has been changed.

    Components take turns, not wires: every label is to be read.
    """

    def trial(cell: Cell, _: PanelWire) -> Outcome:
        components = cell.context.panel.components
        turn, which = divmod(cell.plant.seed, len(components))
        component, terminals = components[which].id, components[which].terminals
        terminal = terminals[turn % len(terminals)].id
        disturb(cell, component)
        seen = locate(cell, component, terminal)
        off = cell.plant.world_from_socket(component, terminal).inverse() @ seen
        cosine = (float(np.trace(off.rotation)) - 1) / 2
        angle = math.degrees(math.acos(min(1.0, max(-1.0, cosine))))
        position = 1e3 * float(np.linalg.norm(off.position))
        return Outcome(True, Code.NONE.name, {"position [mm]": position, "angle [deg]": angle})

    return trial


def moved(cell: Cell, component: str) -> None:
    """Move a component and turn it."""
    values = random_of(cell).uniform(-1, 1, 3) * (SHIFT_M, SHIFT_M, TURN_RAD)
    cell.plant.disturb("component_moved", component, values.tolist())


def relit(cell: Cell, _: str) -> None:
    """Change the light."""
    cell.plant.disturb("light_changed", "", [float(random_of(cell).uniform(*LIGHT))])


def random_of(cell: Cell) -> np.random.Generator:
    """Return what changes are drawn from: not the stream of the cell's own noise."""
    return np.random.default_rng([cell.plant.seed, 1])


def refused(work: Callable[[], object], right: Code) -> Outcome:
    """Do something; good when it fails with the right code."""
    found = code_of(work)
    return Outcome(found.split(":")[0] == right.name, found)


def code_of(work: Callable[[], object]) -> str:
    """Return the code and the message with which an ability fails; "NONE" if it does not."""
    try:
        work()
    except AbilityError as error:
        return f"{error.code.name}: {error}"
    return Code.NONE.name


def is_none(found: str) -> bool:
    """Return whether no code was found."""
    return found == Code.NONE.name


@dataclass(frozen=True)
class Kind:
    """A kind of trial.

    Attributes:
        run: does it.
        what: is counted.
        least: share of good outcomes [%]; None without a target.
        panel: the example panel.
    """

    run: Callable[[Cell, PanelWire], Outcome]
    what: str
    least: float | None = 98.0
    panel: str = "panel"


KINDS = {
    "wire": Kind(place, "whole wires placed, first attempts", None),
    "pick": Kind(pick, "pick"),
    "offset": Kind(offset, "6 mm beside the opening: INSERTION_MISALIGNED"),
    "blocked": Kind(blocked, "blocked socket: INSERTION_JAMMED"),
    "push": Kind(push, "pushed with 4 to 25 N: seated"),
    "push_blocked": Kind(push_blocked, "blocked, pushed with 4 to 25 N: INSERTION_JAMMED"),
    "other_component": Kind(other_component, "wrong socket, of another component: INVALID_GOAL"),
    "neighbour": Kind(neighbour, "wrong socket, the one beside it: INVALID_GOAL"),
    "occupied": Kind(occupied, "wrong socket, occupied: TERMINAL_OCCUPIED"),
    "connector": Kind(seat, "connector latched, first attempt", 95.0, "connectors"),
    "connector_offset": Kind(
        offset, "connector 6 mm aside: INSERTION_MISALIGNED", panel="connectors"
    ),
    "connector_blocked": Kind(
        blocked, "connector, one opening blocked: INSERTION_JAMMED", panel="connectors"
    ),
    "route": Kind(route, "six clips, the whole wire in them after release", 95.0, "formboard"),
    "discard": Kind(discard, "wires discarded, placed or half placed"),
    "locate": Kind(located(lambda *_: None), "located", None),
    "locate_moved": Kind(located(moved), "located, moved by up to 10 mm and 8 deg", None),
    "locate_light": Kind(located(relit), "located, 40 to 160 % of the light", None),
}


def run(task: tuple[str, int, float]) -> Outcome:
    """Run the trial of a name and a seed in a cell of its own, at a rate of the physics [Hz]."""
    name, seed, rate_hz = task
    kind = KINDS[name]
    panel = example(kind.panel)
    with recorded() as records:
        cell = Cell(SimulatedPlant(panel, seed=seed, rate_hz=rate_hz))
        try:
            outcome = kind.run(cell, panel.wires[seed % len(panel.wires)])
        except AbilityError as error:
            outcome = Outcome(False, f"{error.code.name}: {error}")
        except Exception as error:
            error.add_note(f"trial {name}, seed {seed}")
            raise
        finally:
            cell.close()
    return replace(outcome, pushes=tuple((r.limit, r.peak, r.allowed) for r in records))


def figures(outcomes: Mapping[str, Sequence[Outcome]]) -> Iterator[Figure]:
    """Yield the figures of the trials that were run."""
    for name, done in outcomes.items():
        yield _share(KINDS[name].what, [outcome.good for outcome in done], KINDS[name].least)
    placed = [o.figures for o in outcomes.get("wire", ()) if "ends" in o.figures]
    if placed:
        ends = [at < each["ends"] for each in placed for at in range(2)]
        yield _share("insertion, both ends of whole wires, first attempt", ends, 95.0)
        wall, cpu = ([each[key] for each in placed] for key in ("wall [s]", "cpu [s]"))
        yield Figure("a whole wire, wall time, median", float(np.median(wall)), "s", most=WALL_S)
        yield Figure("a whole wire, wall time, slowest", max(wall), "s")
        yield Figure("a whole wire, CPU time, median", float(np.median(cpu)), "s")
    everything = [outcome for done in outcomes.values() for outcome in done]
    pushes = np.array([each for outcome in everything for each in outcome.pushes])
    if pushes.size:
        limits, peaks, allowed = pushes.T
        yield _share("forces at the wrist within 1.15 limits + 0.5 N", list(peaks <= allowed), 99.0)
        yield Figure("largest force at the wrist over its limit", float(np.max(peaks / limits)))
    for key, unit in (("position", "mm"), ("angle", "deg")):
        name = f"{key} [{unit}]"
        errors = [o.figures[name] for o in everything if name in o.figures]
        if errors:
            median, p90 = (float(each) for each in np.quantile(errors, (0.5, 0.9)))
            yield Figure(f"locate: {key}, median", median, unit, most=0.5)
            yield Figure(f"locate: {key}, p90", p90, unit, most=1.0)


def _share(what: str, good: Sequence[bool], least: float | None) -> Figure:
    share = 100 * sum(good) / len(good)
    return Figure(f"{what} ({sum(good)} of {len(good)})", share, "%", least=least)


def mapped(task: tuple[float, float]) -> str:
    """Insert with the error of a goal [deg], [mm]; return what came of it."""
    angle_deg, offset_mm = task
    panel = example("panel")
    wire = panel.wires[0]
    terminal = wire.goes_to(WireEnd.A)
    cell = Cell(SimulatedPlant(panel, seed=1))
    feed(cell, wire)
    error = Pose.level(0.0, offset_mm / 1e3, 0.0, math.radians(angle_deg))
    given = cell.plant.world_from_socket(*terminal) @ error
    goal = InsertGoal(ROBOT, wire.id, WireEnd.A, *terminal, given, FORCE_LIMIT_N)
    found = code_of(lambda: cell.run(insert_cable(cell.context, goal)))
    (truth,) = ground_truth(cell.plant, [wire.id])
    cell.close()
    if is_none(found):
        return "seated" if truth.a.seated else "silently wrong"
    code = found.split(":")[0].removeprefix("INSERTION_").lower()
    return f"{code} (seated)" if truth.a.seated else code


def main() -> int:
    """Run the trials and print the table; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=seeds, default=seeds("0-3"), help="such as 0-99 or 3,7-9")
    parser.add_argument("--trials", nargs="+", choices=KINDS, default=list(KINDS), metavar="NAME")
    parser.add_argument("--rate", type=float, default=240.0, help="of the physics [Hz]")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--map", type=Path, metavar="FILE", help="of the docs' table of insertions")
    options = parser.parse_args()
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(options.jobs, mp_context=spawn) as pool:
        if options.map is not None:
            found = iter(pool.map(mapped, product(ANGLES_DEG, OFFSETS_MM)))
            rows = [
                {"turned": f"{angle:g} deg", **{f"{off:g} mm": next(found) for off in OFFSETS_MM}}
                for angle in ANGLES_DEG
            ]
            report_table(rows, options.map)
            return 0
        tasks = list(product(options.trials, options.seeds, [options.rate]))
        outcomes: dict[str, list[Outcome]] = defaultdict(list)
        for (name, seed, _), outcome in zip(tasks, pool.map(run, tasks), strict=True):
            outcomes[name].append(outcome)
            if not outcome.good:
                print(f"{name}, seed {seed}: {outcome.found}", flush=True)
    return 0 if report(figures(outcomes)) else 1


if __name__ == "__main__":
    sys.exit(main())
