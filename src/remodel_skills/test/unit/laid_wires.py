"""A wire of the household board in shapes that laying leaves, in a cell without a world."""

from functools import cache

import numpy as np
from drawn import along
from panels import example
from scripted_device import ScriptedPlant

from remodel_skills.belief_state import NO_CHANNEL
from remodel_skills.cell import Cell
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import BOARD

HOUSEHOLD = example("household")
CABINET = read_cell("two_arms_cabinet")
WIRE = HOUSEHOLD.wire("W3")
ROUTE = BOARD.apply(np.array(WIRE.route))
# Nodes on each leg of the route, which is so long in its ducts [m].
LEG, IN_DUCTS_M = 40, 0.69
# The legs of the route in its three ducts.
LEGS = (1, 2, 3)
# In a duct, and over its rim [m].
IN_DUCT_M, OVER_RIM_M = 0.030, 0.066


def led(height=IN_DUCT_M, aside=0.0):
    """Return a wire along its route, all at one height, so far aside along both axes [m]."""
    level = np.column_stack([ROUTE[:, :2] + aside, np.full(len(ROUTE), height)])
    return along(level, LEG)


def raised(nodes, leg, height=OVER_RIM_M, aside=0.0):
    """Return a wire that stands out of its duct along most of a leg, so far to its left [m]."""
    first = leg * LEG
    part = slice(first + LEG // 8, first + LEG - LEG // 8)
    towards = (ROUTE[leg + 1] - ROUTE[leg])[:2]
    left = np.array([-towards[1], towards[0]]) / np.linalg.norm(towards)
    nodes[part, :2] += aside * left
    nodes[part, 2] = height
    return nodes


def curled(nodes, share_of_leg=1 / 5, aside=0.016):
    """Return a wire that curls up in the middle of its second duct, to both sides of its leg."""
    first = 5 * LEG // 2
    curl = slice(first, first + round(share_of_leg * LEG))
    nodes[curl, 1] += aside * np.resize([1.0, -1.0], len(nodes[curl]))
    nodes[curl, 2] = OVER_RIM_M
    return nodes


def across_the_devices():
    """Return a wire that sprang out of its ducts, in a loop over the devices between its ends."""
    middle, height = ROUTE[[0, -1], 1].mean(), 0.12
    over = [[x, middle, height] for x in ROUTE[[0, -1], 0]]
    return along([ROUTE[0], *over, ROUTE[-1]], LEG)


@cache
def cabinet():
    """Return a cell; to load its panel again makes a new one of it, in less time."""
    return Cell(ScriptedPlant(HOUSEHOLD, CABINET))


def laid(*shapes):
    """Return a cell that knows the board from before WIRE was laid in these shapes."""
    cell = cabinet()
    cell.load(HOUSEHOLD)
    plant = cell.plant
    cell.feed(WIRE.id, NO_CHANNEL)
    cell.context.cameras.take_overhead_pictures()
    plant.wires = [(WIRE, nodes) for nodes in shapes]
    belief = cell.context.belief
    belief.picked_at.update(dict.fromkeys(belief.ends))  # it was touched
    return cell
