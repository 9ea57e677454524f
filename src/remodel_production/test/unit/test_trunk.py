"""Harnesses whose designs have no segments: a trunk between two rows of connectors, with forks."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from wire_lists import CATALOGUE

from remodel_production.core.board.board import board_of
from remodel_production.core.board.cabinet import laid_out
from remodel_production.core.board.drawing import draw_board
from remodel_production.core.board.panel import panel_of
from remodel_production.core.imports.wireviz import import_wireviz
from remodel_production.core.production import Role, TerminalRef

RULES = CATALOGUE.formboard
EXAMPLE = Path(__file__).parents[3] / "remodel_tasks" / "examples" / "harness.yml"


def harness():
    return import_wireviz(EXAMPLE.read_bytes(), "harness", EXAMPLE.name, CATALOGUE).order


def panel():
    return panel_of(board_of(harness(), CATALOGUE), CATALOGUE)


def openings(made):
    """Return place and direction of insertion of each terminal, panel frame."""
    found = {}
    for device in made.devices:
        x, y = device.place
        cos, sin = math.cos(device.yaw), math.sin(device.yaw)
        for opening in device.openings:
            dx, dy, _ = opening.place
            found[TerminalRef(device.name, opening.name)] = (
                x + cos * dx - sin * dy,
                y + sin * dx + cos * dy,
                math.remainder(device.yaw + opening.insertion_yaw, 2 * math.pi),
            )
    return found


def test_every_wire_runs_straight_from_one_row_to_the_other_and_has_its_slack():
    made = panel()
    places = openings(made)
    for wire in made.wires:
        (ax, ay, a_yaw), (bx, by, b_yaw) = places[wire.a], places[wire.b]
        assert wire.route[0][:2] == pytest.approx((ax, ay), abs=1e-5)
        assert wire.route[1][:2] == pytest.approx((bx, by), abs=1e-5)
        assert wire.length >= math.dist((ax, ay), (bx, by)) + RULES.wire_slack - 1e-6
        # Both are pushed in away from the other row.
        assert (math.sin(a_yaw), math.sin(b_yaw)) == pytest.approx((-1, 1))


def test_forks_are_as_wide_as_the_wires_that_pass_them():
    made = panel()
    assert [fork.name for fork in made.ducts] == ["F1", "F2", "F3"]
    # All wires cross halfway.
    assert made.ducts[1].width == pytest.approx(RULES.fork.play)
    assert made.ducts[0].width == pytest.approx(made.ducts[2].width)
    assert all(wire.ducts == ("F1", "F2", "F3") for wire in made.wires)
    for fork in made.ducts:
        x, y, _ = fork.pose
        for wire in made.wires:
            (ax, ay, _), (bx, by, _) = wire.route
            aside = ax + (y - ay) / (by - ay) * (bx - ax) - x
            assert abs(aside) <= (fork.width - RULES.fork.play) / 2 + 1e-6


def test_everything_stands_on_the_plate():
    made = panel()
    for device in made.devices:
        depth, width, _ = device.size
        cos, sin = abs(math.cos(device.yaw)), abs(math.sin(device.yaw))
        reach = (cos * depth + sin * width) / 2, (sin * depth + cos * width) / 2
        for place, half, size in zip(device.place, reach, made.size[:2], strict=True):
            assert abs(place) + half + RULES.plate_margin <= size / 2 + 1e-6


def test_wires_without_lengths_get_them():
    bare = harness()
    bare = replace(bare, wires=tuple(replace(wire, length_m=None) for wire in bare.wires))
    made = laid_out(bare, CATALOGUE)
    assert sum(made.segments[i].length_m for i in range(4)) == pytest.approx(RULES.trunk)
    assert all(wire.length_m > RULES.trunk for wire in made.wires)


def test_splices_devices_and_rings_of_connectors_have_no_two_sides():
    whole = harness()
    first, *rest = whole.components
    for role in (Role.JOINT, Role.DEVICE):
        other = replace(whole, components=(replace(first, role=role), *rest))
        assert laid_out(other, CATALOGUE).segments[0].name != "trunk"
    loop, *wires = whole.wires
    loop = replace(loop, b=replace(wires[0].a))
    ring = replace(whole, wires=(loop, *wires[1:]))
    assert laid_out(ring, CATALOGUE).segments[0].name != "trunk"


def test_a_turned_connector_is_drawn_turned():
    drawn = draw_board(board_of(harness(), CATALOGUE), CATALOGUE)
    assert drawn.count('transform="rotate(-90.0') == drawn.count('transform="rotate(90.0')
