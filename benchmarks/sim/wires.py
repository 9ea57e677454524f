#!/usr/bin/env python3
"""Measure the simulated cell: how often insertions and whole wires succeed, and how long they take.

Run with the workspace sourced: benchmarks/sim/wires.py [--seeds N] [--insertions N] [--panel FILE].
Each seed lays the wires anew, with other curvature and other camera noise; every wire of the panel
is placed as the task behavior does it, each end with up to three attempts, and the truth is asked
at the end.
"""

import argparse
import statistics
import sys
import time
from collections import Counter
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "src" / "remodel_sim"
sys.path.insert(0, str(PACKAGE / "test" / "unit"))  # the tests place wires as a supervisor does

import place_wire  # noqa: E402

from remodel_sim.cell import Cell  # noqa: E402
from remodel_sim.core.errors import AbilityError  # noqa: E402
from remodel_sim.core.geometry import Pose  # noqa: E402
from remodel_sim.core.panel import End, Panel  # noqa: E402
from remodel_sim.edge.wire_material_file import read_wire_materials  # noqa: E402
from remodel_sim.physics.truth import ground_truth  # noqa: E402
from remodel_sim.ros.conversions import read_panel  # noqa: E402


def channel_of(panel: Panel, wire_id: str) -> str:
    """Return the channel in front of end a's terminal."""
    socket: Pose = panel.panel_from_socket(*panel.wire(wire_id).goes_to(End.A))
    return panel.channel_in_front_of(socket.position).id


def measure_insertions(panel: Panel, seeds: range) -> None:
    """Locate, pick and insert end a of the first wire, once per seed."""
    wire = panel.wires[0]
    component, terminal = wire.goes_to(End.A)
    failures: Counter[str] = Counter()
    for seed in seeds:
        cell = Cell(panel, seed=seed)
        cell.feed(wire.id, channel_of(panel, wire.id))
        try:
            socket = place_wire.locate(cell, component, terminal)
            place_wire.insert(cell, wire.id, End.A, component, terminal, socket)
        except AbilityError as error:
            failures[error.code.name] += 1
        cell.close()
    good = len(seeds) - sum(failures.values())
    say(f"insertions at the first attempt: {good} of {len(seeds)}; failures: {dict(failures)}")


def measure_wires(panel: Panel, seeds: range) -> None:
    """Place every wire of the panel, for each seed."""
    placed, tried, recovered, wall, sim = 0, 0, Counter(), [], []
    lost: Counter[str] = Counter()
    for seed in seeds:
        cell = Cell(panel, seed=seed)
        for wire in panel.wires:
            began = time.perf_counter()
            tried += 1
            try:
                failures = place_wire.place(cell, wire.id, channel_of(panel, wire.id))
                recovered.update(code.name for code in failures)
            except AbilityError as error:
                lost[error.code.name] += 1
                say(f"  seed {seed}, {wire.id}: {error.code.name}: {error}")
            wall.append(time.perf_counter() - began)
            sim.append(cell.plant.world.steps * cell.plant.world.time_step)
            truth = next(t for t in ground_truth(cell.plant, [wire.id]))
            placed += truth.placed
            if not truth.placed:
                say(f"  seed {seed}, {wire.id} is not placed: {truth}")
            if cell.station.book.grip is not None:
                break  # the next wire cannot be fed
        cell.close()
    say(f"whole wires placed, by ground truth: {placed} of {tried}")
    first = 2 * tried - sum(recovered.values()) - sum(lost.values())
    say(f"ends placed at the first attempt: {first} of {2 * tried}")
    say(f"failures that recovery mended: {dict(recovered)}; that ended a wire: {dict(lost)}")
    say(
        f"per wire, median: {statistics.median(wall):.1f} s of wall time, "
        f"{statistics.median(sim):.1f} s simulated; slowest {max(wall):.1f} s of wall time"
    )


def say(text: str) -> None:
    """Print a line at once."""
    print(text, flush=True)  # noqa: T201


def main() -> None:
    """Read the arguments and measure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--panel", type=Path, default=PACKAGE / "config" / "panel.yaml")
    parser.add_argument("--seeds", type=int, default=20, help="of whole wires")
    parser.add_argument("--insertions", type=int, default=50, help="seeds of single insertions")
    parser.add_argument("--first-seed", type=int, default=0)
    arguments = parser.parse_args()
    panel = read_panel(arguments.panel, read_wire_materials())
    first = arguments.first_seed
    measure_wires(panel, range(first, first + arguments.seeds))
    measure_insertions(panel, range(first, first + arguments.insertions))


if __name__ == "__main__":
    main()
