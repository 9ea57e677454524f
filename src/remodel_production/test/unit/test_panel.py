"""The panel of a board: its third dimension, and everything in the frame of the plate."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from boards import loom
from wire_lists import CATALOGUE

from remodel_production.core.board.board import board_of
from remodel_production.core.board.panel import panel_of
from remodel_production.core.imports.qet import import_qet
from remodel_production.core.production import Component, Role
from remodel_states.edge.exported_tables import read_wire_materials

HOUSEHOLD = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")


@pytest.fixture(scope="module")
def board():
    order = import_qet(HOUSEHOLD.read_bytes(), "house", HOUSEHOLD.name, CATALOGUE).order
    return board_of(order, CATALOGUE)


@pytest.fixture(scope="module")
def panel(board):
    return panel_of(board, CATALOGUE)


def spot(device, opening):
    """Return where an opening is on the panel."""
    return tuple(round(a + b, 6) for a, b in zip((*device.place, 0.0), opening.place, strict=True))


def test_all_of_the_household_board_is_on_its_panel(panel):
    assert len(panel.devices) == 30
    assert len(panel.wires) == 58
    assert [rail.name for rail in panel.rails] == ["R1", "R2"]
    assert [duct.name for duct in panel.ducts] == ["D0", "D1", "D2", "L", "R"]
    assert sum(len(device.openings) for device in panel.devices) == 2 * 58


def test_everything_lies_on_the_plate_whose_middle_is_the_origin(panel):
    half_x, half_y = panel.size[0] / 2, panel.size[1] / 2
    edges = []
    for duct in panel.ducts:
        x, y, yaw = duct.pose
        along, across = duct.length / 2, duct.width / 2
        is_row = math.isclose(yaw, math.pi / 2, abs_tol=1e-5)
        dx, dy = (across, along) if is_row else (along, across)
        edges += [(abs(x) + dx, abs(y) + dy)]
    margin = CATALOGUE.cabinet.plate_margin
    assert max(x for x, _ in edges) == pytest.approx(half_x - margin)
    assert max(y for _, y in edges) == pytest.approx(half_y - margin)
    for device in panel.devices:
        assert abs(device.place[0]) + device.size[0] / 2 < half_x - margin
        assert abs(device.place[1]) + device.size[1] / 2 < half_y - margin


def test_the_top_of_the_board_is_away_from_the_robot_and_its_left_is_at_plus_y(board, panel):
    centre = {device.component.name: device.centre for device in board.devices}
    place = {device.name: device.place for device in panel.devices}
    (first, second) = ("D15", "D26")
    assert centre[first][0] < centre[second][0]
    assert place[first][1] > place[second][1]
    up = centre["D15"][1] - centre["CDC749F"][1]
    assert place["D15"][0] - place["CDC749F"][0] == pytest.approx(up)


def test_openings_are_on_the_faces_towards_the_ducts_and_fit_their_wires(panel):
    devices = {device.name: device for device in panel.devices}
    for wire in panel.wires:
        for end, point in ((wire.a, wire.route[0]), (wire.b, wire.route[-1])):
            device = devices[end.component]
            opening = next(o for o in device.openings if o.name == end.terminal)
            side = 1 if opening.insertion_yaw else -1
            assert opening.place[0] == pytest.approx(side * device.size[0] / 2)
            assert spot(device, opening) == point
            assert opening.bore == pytest.approx(wire.material.diameter + 0.0008)
            assert opening.depth > wire.material.ferrule_length
            assert opening.retention == CATALOGUE.clamp(wire.section_mm2).retention_n
            assert opening.screw[2] == device.size[2] == 0.045
            assert opening.place[2] == 0.023
            assert abs(opening.screw[0]) < abs(opening.place[0])


def test_openings_beside_each_other_leave_a_wall_between_them(panel):
    gaps = []
    for device in panel.devices:
        for yaw in (0.0, math.pi):
            row = sorted(
                (o for o in device.openings if o.insertion_yaw == yaw), key=lambda o: o.place[1]
            )
            gaps += [
                b.place[1] - a.place[1] - (a.bore + b.bore) / 2 - a.chamfer - b.chamfer
                for a, b in pairwise(row)
            ]
    assert min(gaps) > 0.0005


def test_thick_wires_have_clamps_a_module_apart(panel):
    main_switch = next(device for device in panel.devices if device.name == "HDA245S")
    left, right = (opening.place[1] for opening in main_switch.openings)
    assert left - right == pytest.approx(0.018)
    assert CATALOGUE.clamp(3.0) == CATALOGUE.clamp(4.0)
    assert CATALOGUE.clamp(95.0) == CATALOGUE.clamp(10.0) != CATALOGUE.clamp(4.0)


def test_ducts_that_meet_reach_to_the_far_wall_of_each_other(panel):
    ducts = {duct.name: duct for duct in panel.ducts}
    top, left = ducts["D0"], ducts["L"]
    assert top.pose[1] + top.length / 2 == pytest.approx(left.pose[1] + left.width / 2)
    assert left.pose[0] + left.length / 2 == pytest.approx(top.pose[0] + top.width / 2)
    assert (top.width, top.height, top.slot_pitch) == (0.040, 0.060, 0.0125)


def test_a_route_runs_in_the_middle_of_its_ducts(panel):
    ducts = {duct.name: duct for duct in panel.ducts}
    for wire in panel.wires:
        # From one duct to the next at each corner.
        assert len(wire.ducts) == len(wire.route) - 3
        for name, (p, q) in zip(wire.ducts, pairwise(wire.route[1:-1]), strict=True):
            duct = ducts[name]
            axis = 0 if math.isclose(duct.pose[2], math.pi / 2, abs_tol=1e-5) else 1
            assert p[axis] == q[axis] == pytest.approx(duct.pose[axis])
            assert p[2] == q[2] == duct.height / 2
        along = sum(math.dist(p[:2], q[:2]) for p, q in pairwise(wire.route))
        assert wire.length == pytest.approx(along + 2 * CATALOGUE.cabinet.tail, abs=2e-3)


def test_slots_let_the_thickest_wire_through(panel):
    assert max(w.material.diameter for w in panel.wires) < min(d.slot_width for d in panel.ducts)


def test_each_device_has_a_label_of_its_own_that_fits_on_it(panel):
    assert len({device.label for device in panel.devices}) == len(panel.devices)
    for device in panel.devices:
        assert 0.011 <= device.label_size <= min(device.size[:2]) * 0.7501


def test_a_formboard_has_clips_for_single_wires_and_forks_for_bundles():
    order = loom()
    board = board_of(order, CATALOGUE)
    panel = panel_of(board, CATALOGUE)
    passing = {
        clip.name: [w.name for w in order.wires if w.route and clip in order.clips_of(w)]
        for clip in order.clips
    }
    assert {clip.name for clip in panel.clips} == {n for n, w in passing.items() if len(w) == 1}
    assert {fork.name for fork in panel.ducts} == {n for n, w in passing.items() if len(w) > 1}
    assert panel.clips or panel.ducts
    assert not panel.rails
    forks = {wire.name: wire.ducts for wire in panel.wires}
    for fork in panel.ducts:
        assert fork.slot_pitch == 0.0
        assert all(fork.name in forks[name] for name in passing[fork.name])


def test_a_wire_of_a_section_beyond_all_materials_has_the_clamps_of_the_nearest():
    order = loom()
    thick = replace(order.wires[0], section_mm2=16.0)
    panel = panel_of(
        board_of(replace(order, wires=(thick, *order.wires[1:])), CATALOGUE), CATALOGUE
    )
    openings = {(d.name, o.name): o for d in panel.devices for o in d.openings}
    for wire in panel.wires:
        is_thick = wire.name == thick.name
        assert (wire.material is None) == is_thick
        bore = openings[wire.a.component, wire.a.terminal].bore
        assert (bore > 0.006) == is_thick


def test_a_wire_between_two_sections_has_the_material_that_the_cell_knows():
    panel = panel_of(board_of(loom(), CATALOGUE), CATALOGUE)
    between = [wire for wire in panel.wires if wire.section_mm2 == 0.35]
    assert between
    assert all(w.material == read_wire_materials().find("", 0.35) for w in between)


def test_classes_of_devices_are_found_by_part_and_kind():
    assert CATALOGUE.device_class(Component("F1", "breaker", ())).depth_m == 0.090
    plug = Component("X1", "plug", (), role=Role.CONNECTOR)
    assert CATALOGUE.device_class(plug).screw_m is None


@pytest.mark.parametrize(
    ("part", "kind", "is_push_in"),
    [
        ("PT 2,5", "terminal block", True),
        ("2002-1301", "terminal block", True),
        ("", "push-in terminal block", True),
        ("UT 2,5", "terminal block", False),
        ("PT100", "sensor", False),
    ],
)
def test_push_in_terminal_blocks_let_ferrules_in_with_a_force_that_their_section_gives(
    part, kind, is_push_in
):
    order = import_qet(HOUSEHOLD.read_bytes(), "house", HOUSEHOLD.name, CATALOGUE).order
    blocks = tuple(replace(c, part_number=part, kind=kind) for c in order.components)
    panel = panel_of(board_of(replace(order, components=blocks), CATALOGUE), CATALOGUE)
    forces = {o.insertion for device in panel.devices for o in device.openings}
    expected = {CATALOGUE.clamp(wire.section_mm2).insertion_n for wire in panel.wires}
    assert forces == (expected if is_push_in else {0.0})
