"""Loose ends of a wire, and all labels of a panel, in drawn pictures from above."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from drawn import bow, boxes_of, picture, standing, tip_of
from panels import panel
from refusals import refused

from remodel_states.core.codes import Code
from remodel_states.core.wires import DISTINCT_COLOURS
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels
from remodel_vision.wire_ends import find_ends, line_between
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

OVERHEAD = read_cell().overheads[0]
PANEL = panel()
WIRE = PANEL.wire("W1")
# Two wires beside each other are so far apart, each so far from where one is expected [m].
APART_M = 0.060


def test_every_label_is_found_from_above_to_half_a_millimetre():
    random = np.random.default_rng(5)
    poses = {
        part.id: BOARD
        @ part.panel_from_component
        @ Pose.level(*random.uniform(-0.006, 0.006, 2), 0.0, random.uniform(-0.1, 0.1))
        for part in PANEL.components
    }
    seen_from_above = picture(OVERHEAD, standing(PANEL, BOARD, poses))
    labels = find_labels(seen_from_above, PANEL.components)
    for part in PANEL.components:
        seen = locate_component(part, [LabelView(seen_from_above, labels[part.marker_id])])
        pose, true = seen.world_from_component, poses[part.id]
        assert np.linalg.norm(pose.position - true.position) < 0.0005
        assert abs(pose.yaw - true.yaw) < math.radians(1.0)
        assert seen.residual < 0.0005


# The darkest, the commonest and the striped one in each run of the tests.
@pytest.mark.parametrize(
    "colour",
    [
        pytest.param(name, marks=[] if name in ("BK", "BU", "GNYE") else pytest.mark.slow)
        for name in DISTINCT_COLOURS
    ],
)
def test_both_ends_of_a_wire_of_any_colour_are_found(colour):
    own, nodes = replace(WIRE, colour=colour), bow(WIRE)
    seen_from_above = picture(OVERHEAD, boxes_of(PANEL), [(own, nodes)])
    tips = {end: tip_of(nodes, end) for end in WireEnd}
    ends, lines = find_ends(seen_from_above, own, {end: tip for end, (tip, _) in tips.items()})
    for end, (true, out) in tips.items():
        seen = ends[end].tip
        assert np.linalg.norm(seen.tip[:2] - true[:2]) < 0.0012
        assert abs(math.cos(seen.out_yaw) * out[0] + math.sin(seen.out_yaw) * out[1]) > 0.99
    pixels = line_between((ends[WireEnd.A], ends[WireEnd.B]), lines)
    line = OVERHEAD.on_plane(pixels, 0.0015)[:, :2]
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    assert length == pytest.approx(WIRE.length, rel=0.03)
    pieces = [np.linspace(a, b, 12) for a, b in pairwise(nodes[:, :2])]
    gaps = np.linalg.norm(line[:, None] - np.concatenate(pieces)[None], axis=2)
    assert gaps.min(axis=1).max() < 0.004, "nothing but the wire, on a plate of its colour too"


def test_a_wire_that_is_not_there_is_not_found():
    seen = picture(OVERHEAD, boxes_of(PANEL), [(WIRE, bow(WIRE))])
    elsewhere = {WireEnd.A: np.array([0.30, -0.30, WIRE.radius])}
    assert find_ends(seen, WIRE, elsewhere)[0] == {}


def test_two_ends_side_by_side_are_ambiguous():
    nodes, aside = bow(WIRE), np.array([APART_M / 2, 0.0, 0.0])
    seen = picture(OVERHEAD, boxes_of(PANEL), [(WIRE, nodes + aside), (WIRE, nodes - aside)])
    with refused(Code.CABLE_AMBIGUOUS):
        find_ends(seen, WIRE, {WireEnd.A: tip_of(nodes)[0]})
