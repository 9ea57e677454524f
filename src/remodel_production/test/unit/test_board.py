"""Boards: cabinets with rows and ducts, formboards, and the drawings of both."""

import math
import tracemalloc
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from boards import loom, order
from lxml import etree
from wire_lists import CATALOGUE

from remodel_production.core.board.board import board_of, length_findings, route_length
from remodel_production.core.board.cabinet import DuctGraph, laid_out
from remodel_production.core.board.drawing import draw_board
from remodel_production.core.board.formboard import flattened, limbs
from remodel_production.core.imports.qet import import_qet
from remodel_production.core.production import (
    Component,
    Node,
    Order,
    Pose,
    Segment,
)

EXAMPLES = Path("/usr/share/qelectrotech/examples")
RULES = CATALOGUE.cabinet
NAMES = (
    "industrial",
    "tableau_domestique",
    "Projet_vierge",
    "weneedpolonez-Polonez_MR89_wiring_diagram",
)


def project(name):
    return import_qet((EXAMPLES / f"{name}.qet").read_bytes(), name, name, CATALOGUE).order


@pytest.mark.parametrize("name", NAMES)
def test_no_two_devices_overlap_and_none_lies_in_a_duct(name):
    board = board_of(project(name), CATALOGUE)
    for first, second in pairwise(sorted(board.devices, key=lambda d: (d.centre[1], d.centre[0]))):
        if first.centre[1] == second.centre[1]:
            apart = second.centre[0] - first.centre[0]
            assert apart >= (first.size[0] + second.size[0]) / 2 - RULES.device_gap
    for start, end in board.lines.values():
        if start[1] == end[1]:
            assert all(
                abs(d.centre[1] - start[1]) >= (d.size[1] + RULES.duct.width) / 2
                for d in board.devices
            )


@pytest.mark.parametrize("name", NAMES)
def test_every_wire_runs_through_ducts_that_hang_together(name):
    board = board_of(project(name), CATALOGUE)
    segments = {segment.name: segment for segment in board.order.segments}
    for wire in board.order.wires:
        if wire.name not in board.routes:
            assert not wire.route
            continue
        for before, after in pairwise(segments[step] for step in wire.route):
            assert {before.start, before.end} & {after.start, after.end}
        assert len(set(wire.route)) == len(wire.route)
        route = board.routes[wire.name]
        assert (route[0], route[-1]) == (board.openings[wire.a], board.openings[wire.b])
        assert all(p[0] == q[0] or p[1] == q[1] for p, q in pairwise(route))
        needed = route_length(route) + 2 * RULES.tail
        if wire.length_m == RULES.shortest:
            assert RULES.shortest - RULES.slack - 2e-3 <= needed <= RULES.shortest + 2e-3
        else:
            assert wire.length_m == pytest.approx(needed, abs=2e-3)
            assert not RULES.shortest - RULES.slack + 2e-3 < needed < RULES.shortest - 2e-3


def test_a_layout_is_the_same_each_time_and_stays_when_it_is_there():
    first = laid_out(project("industrial"), CATALOGUE)
    assert first == laid_out(project("industrial"), CATALOGUE)
    assert laid_out(first, CATALOGUE) is first


def test_rows_are_about_as_long_as_each_other():
    board = board_of(project("industrial"), CATALOGUE)
    rows = Counter()
    for device in board.devices:
        rows[device.centre[1]] += device.size[0]
    assert len(rows) > 3
    assert max(rows.values()) < 1.25 * min(rows.values())


def test_a_wire_takes_the_shortest_way():
    # One row: bottom to top leads around the nearer side.
    laid = laid_out(order(("Q1:B1", "Q2:T1"), ("Q2:T2", "Q9:T1"), ("Q9:T2", "Q8:T1")), CATALOGUE)
    assert laid.wires[0].route[1] == "L0"
    same_duct = laid.wires[1]
    x = {c.name: c.pose.position[0] for c in laid.components}
    assert same_duct.length_m == pytest.approx(
        abs(x["Q9"] - x["Q2"]) + 2 * (RULES.row_pitch - 0.090) / 2 + 2 * RULES.tail, abs=0.01
    )


def test_places_of_the_design_are_kept_and_make_rows():
    given = order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q3:T1"))
    places = {"Q1": (0.1, 0.8, 0.0), "Q2": (0.1, 0.3, 0.0), "Q3": (0.4, 0.31, 0.0)}
    posed = tuple(
        Component(c.name, "", c.terminals, pose=Pose(places[c.name])) for c in given.components
    )
    laid = laid_out(Order("test", "", "", posed, wires=given.wires), CATALOGUE)
    assert {c.name: c.pose.position for c in laid.components} == places
    heights = sorted({node.position[1] for node in laid.nodes})
    assert heights == pytest.approx([0.2, 0.555, 0.91], abs=0.01)
    assert [wire.route for wire in laid.wires] == [("D1.0",), ("D1.0", "D1.1")]


def test_wires_that_lead_away_have_no_route_and_what_is_outside_no_place():
    laid = laid_out(order(("Q1:B1", "Q2:T1"), ("Q2:B1", "M1:T1"), outside=("M1",)), CATALOGUE)
    assert [bool(wire.route) for wire in laid.wires] == [True, False]
    assert [c.pose is None for c in laid.components] == [False, False, True]


def test_an_order_whose_wires_all_lead_away_has_no_layout():
    away = order(("Q1:B1", "M1:T1"), outside=("M1",))
    assert laid_out(away, CATALOGUE) is away


def test_routes_through_a_long_duct_take_little_memory():
    count = 3000
    nodes = tuple(Node(f"N{i}", (float(i), 0.0, 0.0)) for i in range(count + 1))
    segments = tuple(Segment(f"S{i}", f"N{i}", f"N{i + 1}", 1.0) for i in range(count))
    graph = DuctGraph(nodes, segments)
    tracemalloc.start()
    try:
        for i in range(0, count - 1, 300):
            route, length = graph.shortest_route((i + 0.5, 0.0), (count - 0.5, 0.0))
            assert (len(route), length) == (count - i, count - i - 1)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 10e6  # bytes; it took hundreds of millions


def test_points_off_the_ducts_and_ducts_apart_are_reported():
    spots = (("A", 0, 0), ("B", 1, 0), ("C", 0, 2), ("D", 1, 2))
    nodes = tuple(Node(name, (float(x), float(y), 0.0)) for name, x, y in spots)
    graph = DuctGraph(nodes, (Segment("S", "A", "B", 1.0), Segment("T", "C", "D", 1.0)))
    with pytest.raises(ValueError, match="no duct at"):
        graph.shortest_route((3.0, 0.0), (0.5, 0.0))
    with pytest.raises(ValueError, match="do not lead"):
        graph.shortest_route((0.5, 0.0), (0.5, 2.0))


TREE = [
    *(Segment("1", "A", "B", 0.4), Segment("2", "B", "C", 0.3), Segment("3", "B", "D", 0.2)),
    *(Segment("4", "D", "E", 0.1), Segment("5", "D", "F", 0.05), Segment("6", "X", "Y", 0.5)),
]


def test_a_formboard_keeps_the_lengths_of_a_tree():
    places = flattened("ABCDEFXY", TREE)
    for segment in TREE:
        distance = math.dist(places[segment.start], places[segment.end])
        assert distance == pytest.approx(segment.length_m)
    assert len({(round(x, 6), round(y, 6)) for x, y in places.values()}) == 8


def test_a_ring_of_segments_is_cut_open():
    ring = [Segment(str(i), "ABC"[i], "BCA"[i], 1.0) for i in range(3)]
    assert set(flattened("ABC", ring)) == set("ABC")


def test_every_segment_of_a_tree_is_in_one_limb_and_the_trunk_is_the_longest_way():
    found = limbs("ABCDEFXYZ", TREE)
    steps = sorted(tuple(sorted(pair)) for limb in found for pair in pairwise(limb.nodes))
    assert steps == sorted((segment.start, segment.end) for segment in TREE)
    assert {limb.nodes[0] + limb.nodes[-1] for limb in found if limb.parent is None} <= {
        *("AC", "CA", "AE", "EA", "XY", "YX")
    }
    for limb in found:
        if limb.parent is not None:
            assert limb.nodes[0] in found[limb.parent].nodes
            assert limb.level == found[limb.parent].level + 1


def test_a_harness_lies_on_a_formboard_with_its_clips():
    board = board_of(loom(), CATALOGUE)
    assert not board.is_cabinet
    assert set(board.clips) == {"CL1", "CL2", "CL3"}
    assert set(board.routes) == {"11", "SL1.31"}
    start, end = board.lines["S1"]
    assert math.dist(board.clips["CL1"], start) == pytest.approx(0.1)
    assert math.dist(start, end) == pytest.approx(0.4)


def test_a_connector_without_a_node_lies_below_the_harness():
    harness = loom()
    loose = tuple(
        Component(c.name, c.kind, c.terminals) if c.name == "X3" else c for c in harness.components
    )
    board = board_of(Order("loom", "", "", loose, wires=harness.wires, nodes=harness.nodes,
                           segments=harness.segments, clips=harness.clips), CATALOGUE)  # fmt: skip
    centres = {device.component.name: device.centre for device in board.devices}
    assert centres["X3"][1] < min(centres["X1"][1], centres["X2"][1])


@pytest.mark.parametrize("order_of", [loom, lambda: project("industrial")])
def test_a_drawing_shows_every_device_and_every_wire(order_of):
    board = board_of(order_of(), CATALOGUE)
    text = draw_board(board, CATALOGUE)
    assert text == draw_board(board_of(order_of(), CATALOGUE), CATALOGUE)
    svg = etree.fromstring(text.encode())
    space = {"s": "http://www.w3.org/2000/svg"}
    labels = Counter(node.text for node in svg.findall("s:text", space))
    assert labels == Counter(device.component.name for device in board.devices)
    drawn = [title.text.split(":")[0] for title in svg.iterfind("s:g/s:title", space)]
    assert sorted(drawn) == sorted(name.split(":")[0] for name in board.routes)
    _, _, width, height = map(float, svg.get("viewBox").split())
    points = " ".join(line.get("points") for line in svg.iterfind("s:g/s:polyline", space))
    for pair in points.split():
        x, y = map(float, pair.split(","))
        assert 0 <= x <= width
        assert 0 <= y <= height


def test_a_drawing_tells_wires_and_terminals_by_their_names():
    made = order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2"))
    first, second = made.wires
    odd = """<'1'> & "2\""""
    board = board_of(replace(made, wires=(replace(first, name=odd), second)), CATALOGUE)
    svg = etree.fromstring(draw_board(board, CATALOGUE).encode())
    ends = {each.get("data-wire"): (each.get("data-a"), each.get("data-b")) for each in svg.iter()}
    del ends[None]
    assert ends == {odd: ("Q1:B1", "Q2:T1"), second.name: ("Q1:B2", "Q2:T2")}
    terminals = {each.get("data-terminal") for each in svg.iter()} - {None}
    assert terminals == {"Q1:B1", "Q1:B2", "Q2:T1", "Q2:T2"}


def test_a_cabinet_is_drawn_to_scale():
    board = board_of(project("tableau_domestique"), CATALOGUE)
    svg = etree.fromstring(draw_board(board, CATALOGUE).encode())
    space = {"s": "http://www.w3.org/2000/svg"}
    sizes = {
        rect.findtext("s:title", namespaces=space): float(rect.get("width"))
        for rect in svg.iterfind("s:rect", space)
    }
    device = next(d for d in board.devices if d.component.name == "Q1")
    scale = sizes[f"Q1 {device.component.kind}"] / device.size[0]
    thick, thin = (CATALOGUE.material(section).diameter + 0.0008 for section in (10.0, 2.5))
    assert sizes["Q1:T1.1"] == pytest.approx(thick * scale, abs=0.1)
    assert sizes["Q1:B1.1"] == pytest.approx(thin * scale, abs=0.1)
    lines = svg.findall("s:line", space)
    fingers = [line.get("stroke-dasharray") for line in lines if line.get("stroke-dasharray")]
    assert len(fingers) == len(board.lines)
    assert sum(map(float, fingers[0].split())) == pytest.approx(
        RULES.duct.slot_pitch * scale, abs=0.1
    )
    rails = [float(line.get("stroke-width")) for line in lines if line.get("stroke") == "#c9c9c0"]
    assert rails == pytest.approx([RULES.rail.width * scale] * 2, abs=0.1)


def test_lengths_of_the_design_that_do_not_fit_the_board_are_found():
    made = order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2"), ("Q1:B3", "Q2:T3"), ("Q1:B4", "Q2:T4"))
    lengths = (0.01, 90.0, None, 0.9)
    wires = (replace(w, length_m=m) for w, m in zip(made.wires, lengths, strict=True))
    board = board_of(replace(made, wires=tuple(wires)), CATALOGUE)
    needed = route_length(board.routes["W4"])
    board = replace(
        board,
        order=replace(
            board.order,
            wires=tuple(
                replace(w, length_m=needed) if w.name == "W4" else w for w in board.order.wires
            ),
        ),
    )
    short, long, _ = length_findings(board, {"W1", "W2", "W4"})
    assert [line.split(",")[0] for line in short] == ["W1: 0.01 m"]
    assert [line.split(",")[0] for line in long] == ["W2: 90 m"]
    assert length_findings(board, set()) == ((), (), ())


def test_a_wire_of_a_harness_must_be_as_long_as_its_segments():
    made = loom()
    for length_m, short in ((0.72, []), (0.71, ["11"])):  # of segments of 0.4 m and 0.32 m
        wire = replace(made.wires[0], length_m=length_m)
        board = board_of(replace(made, wires=(wire, *made.wires[1:])), CATALOGUE)
        found = length_findings(board, {wire.name})
        assert [line.split(":")[0] for line in found[0]] == short
        assert found[1] == ()
