"""Wires on a board in depth pictures from above: where one can be grasped, and what stands out."""

import math

import numpy as np
import pytest
from drawn import ARCH_Y, along, arch, boxes_of, picture
from panels import example, panel

from remodel_vision.opening_occupancy import is_seen_empty
from remodel_vision.standing import CELL_M, graspable_places, standing_wires
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.obstacles import WIRES, panel_obstacles
from remodel_work.panel import BOARD, WireEnd
from remodel_work.routes import opening_of

OVERHEAD = read_cell("two_arms_cabinet").overheads[0]
HOUSEHOLD = example("household")
WIRE = HOUSEHOLD.wire("W15")
LEG = 40
# Over the rims of the ducts, and in them [m].
OVER_RIM_M, IN_DUCT_M = 0.066, 0.030
# A place on a wire is so near to one of its nodes [m], and turned from it by no more than this
# [sine]; the depth camera errs by less than this, three times its noise [m].
NEAR_NODE_M, ALONG, SEEN_HEIGHT_M = 0.010, 0.05, 0.003
# An end is so deep in its terminal [m].
DEEP_M = 0.010


@pytest.mark.parametrize("leg", [1, 2])
def test_a_new_wire_is_graspable_where_it_is_highest(leg):
    route = BOARD.apply(np.array(HOUSEHOLD.wire("W3").route))
    lies = along(np.column_stack([route[:, :2], np.full(len(route), IN_DUCT_M)]), LEG)
    high = slice(leg * LEG + LEG // 4, leg * LEG + 3 * LEG // 4)
    lies[high, 2] = OVER_RIM_M
    boxes = boxes_of(HOUSEHOLD)
    before, now = picture(OVERHEAD, boxes), picture(OVERHEAD, boxes, [(WIRE, lies)], seed=1)
    first, *others = graspable_places(now, before, WIRE.radius)
    assert np.linalg.norm(lies[high] - first.position, axis=1).min() < NEAR_NODE_M
    assert first.position[2] == pytest.approx(OVER_RIM_M, abs=SEEN_HEIGHT_M)
    way = lies[high][-1] - lies[high][0]
    assert abs(math.sin(first.yaw - math.atan2(way[1], way[0]))) < ALONG
    assert all(place.position[2] < OVER_RIM_M + SEEN_HEIGHT_M for place in others)
    assert not list(graspable_places(now, now, WIRE.radius)), "nothing is new"


def test_only_the_openings_of_a_wire_are_not_seen_empty():
    wire = HOUSEHOLD.wire("W96")
    inside = [
        opening_of(wire.goes_to(end), HOUSEHOLD, {}).apply(np.array([DEEP_M, 0.0, 0.0]))
        for end in WireEnd
    ]
    route = BOARD.apply(np.array(wire.route))
    route[1:-1, 2] = IN_DUCT_M
    nodes = along([inside[0], *route, inside[1]])
    shown = picture(OVERHEAD, boxes_of(HOUSEHOLD), [(wire, nodes)])
    keys = [(part.id, each.id) for part in HOUSEHOLD.components for each in part.terminals]
    taken = {key for key in keys if not is_seen_empty(shown, opening_of(key, HOUSEHOLD, {}), wire)}
    assert taken == {wire.goes_to(end) for end in WireEnd}


@pytest.mark.parametrize("cell", ["cabinet", "two_arms_cabinet"])
def test_a_wire_that_stands_out_of_the_plate_is_seen_and_nothing_else(cell):
    plate, view, nodes = panel(channels=()), read_cell(cell).overheads[0], arch()
    drawn = panel_obstacles(plate, {})
    assert not standing_wires([picture(view, boxes_of(plate))], plate, drawn).solids
    shown = picture(view, boxes_of(plate), [(plate.wire("W2"), nodes)])
    columns = standing_wires([shown], plate, drawn).solids
    assert {column.name for column in columns} == {WIRES}
    for column in columns:
        (x, y, middle), height = column.box.centre, column.box.size[2]
        assert abs(y - ARCH_Y) < 2 * CELL_M
        beneath = nodes[np.abs(nodes[:, 0] - x) <= CELL_M, 2]
        assert beneath.min() - 0.004 < middle + height / 2 < beneath.max() + 0.006


def test_a_wire_that_stands_out_of_a_turned_plate_is_seen_up_to_its_edge():
    turned = BOARD @ Pose.level(0.0, 0.0, 0.0, math.pi / 2)
    plate = panel(channels=(), components=(), size=(0.70, 0.40, 0.003), world_from_panel=turned)
    nodes = arch()
    nodes[:, 1] = 0.30
    shown = picture(OVERHEAD, boxes_of(plate), [(plate.wire("W2"), nodes)])
    columns = standing_wires([shown], plate, panel_obstacles(plate, {})).solids
    assert columns
    assert all(abs(column.box.centre[1] - 0.30) < 2 * CELL_M for column in columns)
