"""Connectors of a harness without segments stand where the lengths of its wires fit."""

import math
from itertools import pairwise
from pathlib import Path

import pytest
from wire_lists import CATALOGUE

from remodel_production.core.board.board import board_of, length_findings
from remodel_production.core.board.panel import panel_of
from remodel_production.core.imports.wireviz import import_wireviz
from remodel_states.core.cell import SPARE_M

DESIGNS = Path(__file__).with_name("designs")
HARNESS = DESIGNS.parents[3] / "remodel_tasks/examples/harness.yml"
BODY_PAST_M = 0.006


def bundles(*lengths):
    """Return a WireViz file: two wires of a length in mm for each (from, to, length)."""
    used = {}
    cables, connections = {}, []
    for number, (a, b, length) in enumerate(lengths, start=1):
        ends = []
        for name in (a, b):
            first = used.get(name, 0) + 1
            used[name] = first + 1
            ends.append({name: [f"{first}-{first + 1}"]})
        cables[f"W{number}"] = length
        connections.append([ends[0], {f"W{number}": ["1-2"]}, ends[1]])
    lines = ["connectors:"]
    lines += [f"  {name}: {{pincount: {count}}}" for name, count in used.items()]
    lines += ["cables:"]
    lines += [
        f"  {name}: {{category: bundle, gauge: 0.75 mm2, length: {mm} mm, colors: [BU, RD]}}"
        for name, mm in cables.items()
    ]
    lines += ["connections:"]
    lines += [f"  - {connection}".replace("'", "") for connection in connections]
    return "\n".join(lines).encode()


def board(data):
    return board_of(import_wireviz(data, "harness", "harness.yml", CATALOGUE).order, CATALOGUE)


def slacks(made):
    """Return by how much each wire is longer than its straight line, by its name [m]."""
    panel = panel_of(made, CATALOGUE)
    return {w.name: w.length - math.dist(*(p[:2] for p in w.route)) for w in panel.wires}


def fits(slack):
    return SPARE_M[0] - 1e-5 <= slack <= SPARE_M[1] + 1e-5


def assert_free(made):
    """Assert that connectors overlap neither each other nor the wires that pass them."""
    panel = panel_of(made, CATALOGUE)
    boxes = {}
    for device in panel.devices:
        depth, width, _ = device.size
        boxes[device.name] = (*device.place, width / 2, depth / 2)
    for (one, first), (other, second) in ((p, q) for p in boxes.items() for q in boxes.items()):
        if one < other:
            apart = [abs(first[i] - second[i]) - first[2 + i] - second[2 + i] for i in (0, 1)]
            assert max(apart) > 0, (one, other)
    for wire in panel.wires:
        ends = {wire.a.component, wire.b.component}
        for share in (k / 200 for k in range(201)):
            at = [p + share * (q - p) for p, q in zip(*(p[:2] for p in wire.route), strict=True)]
            for name, (x, y, half_x, half_y) in boxes.items():
                beside = max(abs(at[0] - x) - half_x, abs(at[1] - y) - half_y)
                assert name in ends or beside > BODY_PAST_M, (wire.name, name)


@pytest.mark.parametrize(
    "data",
    [
        pytest.param(bundles(("X1", "X2", 600), ("X1", "X3", 450)), id="two lengths"),
        pytest.param(
            bundles(("X1", "X2", 900), ("X1", "X3", 500), ("X1", "X4", 700)), id="three lengths"
        ),
        pytest.param(
            bundles(("A", "B", 600), ("C", "B", 500), ("C", "D", 700), ("E", "D", 520)),
            id="a chain",
        ),
        pytest.param(bundles(("A", "B", 600), ("C", "D", 900)), id="two parts"),
        pytest.param(
            bundles(("A", "C", 560), ("A", "D", 600), ("B", "C", 600), ("B", "D", 560)),
            id="a ring that needs both directions",
        ),
        *(
            pytest.param(file.read_bytes(), id=file.stem)
            for file in (HARNESS, DESIGNS / "seat.yml", DESIGNS / "lamp.yml")
        ),
    ],
)
def test_connectors_stand_where_every_wire_has_its_slack(data):
    made = board(data)
    assert all(map(fits, slacks(made).values())), slacks(made)
    assert_free(made)
    stated = {wire.name for wire in made.order.wires}
    assert length_findings(made, stated) == ((), (), ())


def test_a_bundle_longer_than_the_rest_of_its_ring_is_named_and_the_others_fit():
    made = board(bundles(("A", "C", 560), ("A", "D", 600), ("B", "C", 600), ("B", "D", 2400)))
    unfit = {name for name, slack in slacks(made).items() if not fits(slack)}
    assert unfit == {"W4.1", "W4.2"}
    *_, (line,) = length_findings(made, {wire.name for wire in made.order.wires})
    assert line == (
        "B to D: 2.4 m, and the way around it only 1.76 m (B to C 0.6 m, C to A 0.56 m, A to D "
        "0.6 m)"
    )


def test_wires_pass_the_forks_between_their_connectors_in_order_and_within_the_posts():
    made = board((DESIGNS / "lamp.yml").read_bytes())
    panel = panel_of(made, CATALOGUE)
    forks = {fork.name: fork for fork in panel.ducts}
    for wire in panel.wires:
        (ax, ay), (bx, by) = (point[:2] for point in wire.route)
        assert wire.ducts
        places = [forks[name].pose[1] for name in wire.ducts]
        assert all((q - p) * (by - ay) > 0 for p, q in pairwise([ay, *places, by]))
        for name in wire.ducts:
            x, y, _ = forks[name].pose
            aside = ax + (y - ay) / (by - ay) * (bx - ax) - x
            assert abs(aside) <= (forks[name].width - CATALOGUE.formboard.fork.play) / 2 + 1e-5
