"""Wires as placing leaves them, so that a test does not have to place them first.

`PYTHONPATH=src/remodel_work/test:$PYTHONPATH python3 src/remodel_sim/test/unit/stored.py`, in the
sourced workspace, places the wires of WIRES and writes their shapes again: after a change of the
physics that leaves wires elsewhere. W96 of the household panel is how
that wire lay among 47 others when its second end was in; it is kept.
"""

import json
import math
from pathlib import Path

import numpy as np
import place_wire
from formboards import formboard
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.belief_state import EndState, Grip
from remodel_skills.cell import Cell
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.placed_wires import ParkedWire, PlacedWires

FILE = Path(__file__).with_name("stored_wires.json")
# Panels, and wires of them.
WIRES = ((panel(), "W1"), (formboard(2), "W1"))


def shape_of(cell, wire_id, *fixed):
    """Return a stored wire whose ends `fixed` are in their terminals, the other one in the channel.

    The shape of one that is fixed at both ends is that of a placed wire.
    """
    name = f"{cell.plant.loaded.name}/{wire_id}/{''.join(end.value for end in fixed)}"
    nodes = np.array(json.loads(FILE.read_text())[name]) / 1e3
    return ParkedWire(nodes, frozenset(fixed))


def stored(panel_of, wire_id, shape):
    """Return what a cell remembers of a wire."""
    wire = panel_of.wire(wire_id)
    occupied = {wire.goes_to(end): (wire_id, end) for end in shape.fixed}
    return PlacedWires({wire_id: shape}, occupied)


def put(cell, wire_id, *fixed):
    """Put a wire into a fresh cell, parked as it would be with these ends fixed."""
    placed = stored(cell.plant.loaded, wire_id, shape_of(cell, wire_id, *fixed))
    cell.plant.load(cell.plant.loaded, placed.parked)
    cell.context.belief.restore(placed)


def put_live(cell, wire_id):
    """Put a live wire into a fresh cell: a is fixed, and b lies in the feeder's fork."""
    cell.feed(wire_id, "A")
    plant, belief = cell.plant, cell.context.belief
    tip, out = plant.live.cable.tip(WireEnd.A)
    lay_at = Grip.of_tip(WireEnd.A, Pose.level(*tip, math.atan2(out[1], out[0])))
    plant.live.cable.lay_along(shape_of(cell, wire_id, WireEnd.A).nodes)
    terminal = plant.panel.wire(wire_id).goes_to(WireEnd.A)
    assert plant.close_clamp(*terminal)
    belief.picked_at[WireEnd.A] = lay_at
    belief.seat(WireEnd.A, terminal)
    belief.ends[WireEnd.A] = EndState.FIXED
    cell.come_to_rest()


def record():
    """Place the wires; return their shapes [mm]."""
    shapes = {}
    for board, wire_id in WIRES:
        cell = Cell(SimulatedPlant(board, seed=1))
        cell.feed(wire_id, "A")
        place_wire.connect(cell, wire_id, WireEnd.A)
        shapes[f"{board.name}/{wire_id}/a"] = cell.plant.live.cable.nodes()
        if not board.clips:
            place_wire.carry(cell, wire_id, "A")
            place_wire.connect(cell, wire_id, WireEnd.B)
            shapes[f"{board.name}/{wire_id}/ab"] = cell.plant.parked[wire_id].nodes
        cell.close()
    return {name: np.round(1e3 * nodes, 2).tolist() for name, nodes in shapes.items()}


if __name__ == "__main__":
    known = json.loads(FILE.read_text()) | record()
    shapes = [f"{json.dumps(name)}: {json.dumps(nodes)}" for name, nodes in known.items()]
    FILE.write_text("{\n" + ",\n".join(shapes) + "\n}\n")
