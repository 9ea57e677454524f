"""Mating a connector with its header: by physics, and what is refused before anything moves."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from place_wire import ROBOT, do, extract, locate

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills import goals
from remodel_skills.abilities.place_connector import place_connector
from remodel_skills.belief_state import BeliefState, EndState, Feed
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.codes import Code
from remodel_states.edge.wire_material_file import read_wire_materials
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError, PanelError
from remodel_work.geometry import Pose
from remodel_work.layout import find_problems as problems_of
from remodel_work.panel import BOARD, WireEnd
from remodel_work.ros.panel_message import read_panel

PARAMETERS = read_parameters().parameters

CONFIG = Path(__file__).parents[2] / "config"
PANEL = read_panel(CONFIG / "connectors.yaml", read_wire_materials())
FACE = BOARD @ PANEL.panel_from_socket("U1", "J1")


@pytest.fixture
def cell():
    """A freshly built cell, W1 with its connector P1 fed."""
    made = Cell(SimulatedPlant(PANEL, seed=1))
    made.feed("W1", "A")
    yield made
    made.close()


def connection(**changes):
    fields = dict(
        robot_name=ROBOT,
        connector_id="P1",
        cable_id="W1",
        component_id="U1",
        terminal_id="J1",
        socket=FACE,
        force_limit=30.0,
    )
    return goals.ConnectGoal(**{**fields, **changes})


def place(cell, socket, force=30.0):
    return do(cell, place_connector, connection(socket=socket, force_limit=force))


def truth_of(cell):
    (truth,) = ground_truth(cell.plant, ["W1"])
    return truth.a


@pytest.mark.physics
def test_a_connector_latches_when_pushed_hard_enough_and_comes_out_when_its_latch_is_opened(cell):
    socket = locate(cell, "U1", "J1")
    with pytest.raises(AbilityError, match="did not latch") as caught:
        place(cell, socket, force=4.0)
    assert caught.value.code is Code.INSUFFICIENT_FORCE
    assert not truth_of(cell).fixed
    placed = place(cell, socket)
    assert placed.peak_force >= 30.0
    assert truth_of(cell).seated and truth_of(cell).fixed
    assert cell.context.belief.ends[WireEnd.A] is EndState.FIXED
    assert cell.context.belief.grip is None
    extract(cell, "W1", "U1", "J1", socket=socket)
    assert truth_of(cell).at == "" and not truth_of(cell).fixed


@pytest.mark.slow
@pytest.mark.physics
def test_pins_beside_their_openings_and_an_obstacle_in_one_have_different_codes(cell):
    socket = locate(cell, "U1", "J1")
    beside = Pose(socket.position + np.array([0.0, 0.006, 0.0]), socket.quaternion)
    with pytest.raises(AbilityError) as caught:
        place(cell, beside)
    assert caught.value.code is Code.INSERTION_MISALIGNED
    extract(cell, "W1", "U1", "J1", socket=beside)
    cell.plant.block_socket("U1", "J1")
    with pytest.raises(AbilityError) as caught:
        place(cell, socket)
    assert caught.value.code is Code.INSERTION_JAMMED
    assert 0.003 < caught.value.found["depth"] < 0.0065


@pytest.mark.parametrize(
    ("goal", "code", "words"),
    [
        (lambda: connection(connector_id="P9"), Code.UNKNOWN_NAME, "there are: P1"),
        (lambda: connection(force_limit=-1.0), Code.INVALID_GOAL, "allowed: 1 to 40 N"),
        (lambda: connection(robot_name=""), Code.INVALID_GOAL, "robot_name is empty"),
        (
            lambda: connection(component_id="U2"),
            Code.INVALID_GOAL,
            "'P1' has 3 ways, 5.08 mm apart; 'U2/J1' takes 2",
        ),
        (lambda: connection(terminal_id="J2"), Code.INVALID_GOAL, "at the opening of 'U1/J1'"),
        (
            lambda: goals.InsertGoal(
                robot_name=ROBOT,
                cable_id="W1",
                end=WireEnd.A,
                component_id="X1",
                terminal_id="1",
                socket=FACE,
                force_limit=8.0,
            ),
            Code.INVALID_GOAL,
            "place it with PlaceConnector",
        ),
        (
            lambda: goals.FixGoal(
                robot_name=ROBOT,
                cable_id="W1",
                component_id="U1",
                terminal_id="J1",
                pull_test_force=5.0,
            ),
            Code.INVALID_GOAL,
            "is a header",
        ),
        (lambda: goals.CheckGoal("W1", WireEnd.A, "U1", "J1"), Code.INVALID_GOAL, "is a header"),
    ],
)
def test_goals_that_cannot_be_done_are_refused_with_the_reason(goal, code, words):
    belief = BeliefState()
    belief.start_wire(Feed("W1", "A", 1), {})
    with pytest.raises(AbilityError, match=words) as caught:
        goal().check(PANEL, belief, PARAMETERS)
    assert caught.value.code is code


def find_problems(found):
    design = read_cell()
    return problems_of(found, design.arms, design.takes)


def with_connector(**changes):
    first = PANEL.wires[0]
    changed = dataclasses.replace(first.connectors[0], **changes)
    wires = (dataclasses.replace(first, connectors=(changed,)), PANEL.wires[1])
    return dataclasses.replace(PANEL, wires=wires)


def with_header(**changes):
    first = PANEL.components[0]
    header = dataclasses.replace(first.terminals[0], **changes)
    changed = dataclasses.replace(first, terminals=(header, *first.terminals[1:]))
    return dataclasses.replace(PANEL, components=(changed, *PANEL.components[1:]))


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (with_connector(ways=2), "'P1' has 2 ways, 5.08 mm apart, and 'U1/J1' has 3"),
        (with_connector(end=WireEnd.B), "end a has no connector, and 'U1/J1' is a header"),
        (with_connector(pin_length=0.0099), "'P1', 0.0099 m long, do not go into 'U1/J1'"),
        (with_connector(pin_diameter=0.0022), "opening of 'U1/J1' minus diameter is 0.2 mm"),
        (with_connector(body_width=0.03), "'P1': body_width is 0.03 m"),
        (with_connector(mating_force=80.0), "'P1': mating_force is 80 N"),
        (with_connector(id="P2"), "2 of the connectors are called 'P2'"),
        (with_header(pitch=0.004), "its openings are -0.4 mm apart"),
        (with_header(retention_force=5.0), "'U1/J1': retention_force is 5 N"),
        (with_header(mouth=(0.025, -0.030, 0.022)), "reaches beyond the component's side"),
    ],
)
def test_connectors_and_headers_that_do_not_work_are_reported(broken, words):
    problems = find_problems(broken)
    assert any(words in problem for problem in problems), problems


def test_the_panel_with_connectors_has_no_problem():
    assert find_problems(PANEL) == ()


def test_a_connector_at_no_end_is_reported_with_its_wire(tmp_path):
    text = (CONFIG / "connectors.yaml").read_text().replace("{id: P1, end: a", "{id: P1, end: c")
    (tmp_path / "panel.yaml").write_text(text)
    with pytest.raises(PanelError, match="wire 'W1': connector 'P1': end is 'c'; allowed: a, b"):
        read_panel(tmp_path / "panel.yaml", read_wire_materials())
