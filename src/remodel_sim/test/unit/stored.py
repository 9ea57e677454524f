"""Wires as placing leaves them, so that a test does not have to place them first.

`PYTHONPATH=src/remodel_work/test:$PYTHONPATH python3 src/remodel_sim/test/unit/stored.py`, in the
sourced workspace, places the wires of WIRES and writes their shapes again: after a change of the
physics that leaves wires elsewhere. W96 of the household panel is how
that wire lay among 47 others when its second end was in; it is kept.
"""

import dataclasses
import json
import math
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import place_wire
from formboards import formboard
from panels import example, panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.abilities.picking import DetectGoal, PickGoal
from remodel_skills.belief_state import EndState, Grip
from remodel_skills.cell import Cell
from remodel_skills.primitives.motions import fingers_still
from remodel_skills.robot_context import run
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import ParkedWire, PlacedWires

FILE = Path(__file__).with_name("stored_wires.json")
HELD_FILE = FILE.with_name("stored_held_wire.json")
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


def put_held(cell, wire_id):
    """Put a live wire into a fresh cell as LayWire finds it: a is fixed, and a hand holds b.

    Returns:
        The robot that holds it.
    """
    kept = json.loads(HELD_FILE.read_text())[f"{cell.plant.loaded.name}/{wire_id}"]
    pictures = cell.context.cameras.take_overhead_pictures()
    for name, tool in kept["tools"].items():
        cell.contexts[name].commanded = ToolPose(*tool)
    cell.feed(wire_id, "")
    plant, cable = cell.plant, cell.plant.live.cable
    for end in WireEnd:
        plant.open_magazine(end)
    cable.lay_along(np.array(kept["nodes"]) / 1e3)
    terminal = plant.panel.wire(wire_id).goes_to(WireEnd.A)
    assert plant.close_clamp(*terminal)
    holder = cell.contexts[kept["robot"]]
    with held_still(plant.world.bullet, cable, WireEnd.B):
        holder.close_fingers(plant.panel.wire(wire_id).diameter)
        run(plant.tick, fingers_still(holder))
    belief = holder.belief
    grip = Grip(WireEnd.B, *kept["grip"], tool=holder.commanded)
    belief.picked_at.update({WireEnd.A: grip, WireEnd.B: grip})
    belief.seat(WireEnd.A, terminal)
    belief.ends[WireEnd.A] = EndState.FIXED
    belief.grip = grip
    belief.untouched[:] = pictures
    cell.come_to_rest()
    return holder.name


@contextmanager
def held_still(bullet, cable, end):
    """Hold an end of a wire where it is, while fingers close around it."""
    link = cable.ferrule(end)
    at, turn = cable.link_pose(link)
    hold = bullet.createConstraint(
        *link, -1, -1, bullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], at.tolist(), [0, 0, 0, 1],
        turn.tolist(),
    )  # fmt: skip
    bullet.changeConstraint(hold, maxForce=500)
    yield
    bullet.removeConstraint(hold)


def record_held():
    """Fix end a of a wire of the household while a hand holds b; return it as it is then."""
    cell = Cell(SimulatedPlant(example("household"), design=read_cell("two_arms_cabinet"), seed=1))
    robot, wire_id = "robot_2", "W3"
    cell.feed(wire_id, "")
    place_wire.do(cell, place_wire.detect_cable, DetectGoal(wire_id))
    key = cell.plant.panel.wire(wire_id).goes_to(WireEnd.A)
    socket = place_wire.locate(cell, *key)
    holder = cell.contexts[robot]
    pick = PickGoal(robot, wire_id, WireEnd.B, 0.0)
    cell.run(place_wire.pick_cable(holder, pick), robot)
    place_wire.insert(cell, wire_id, WireEnd.A, *key, socket)
    place_wire.fix(cell, wire_id, *key, pull=5.0)
    tools = {
        name: [round(float(v), 5) for v in dataclasses.astuple(context.commanded)]
        for name, context in cell.contexts.items()
    }
    grip = holder.belief.grip
    held = {
        "robot": robot,
        "tools": tools,
        "grip": [round(v, 5) for v in (grip.distance, grip.height, grip.flip)],
        "nodes": np.round(1e3 * cell.plant.live.cable.nodes(), 2).tolist(),
    }
    cell.close()
    return {f"{cell.plant.loaded.name}/{wire_id}": held}


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
    HELD_FILE.write_text(json.dumps(record_held()) + "\n")
