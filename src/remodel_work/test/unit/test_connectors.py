"""Which connectors fit their headers."""

import dataclasses
from functools import partial

import pytest
from panels import EXAMPLES, example, with_first, with_first_terminal

from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import PanelError
from remodel_work.layout import find_problems as problems_of
from remodel_work.panel import WireEnd
from remodel_work.ros.panel_message import read_panel

PANEL = example("connectors")


def find_problems(found):
    design = read_cell()
    return problems_of(found, design.arms, design.takes)


def with_connector(**changes):
    changed = dataclasses.replace(PANEL.wires[0].connectors[0], **changes)
    return with_first(PANEL, "wires", connectors=(changed,))


with_header = partial(with_first_terminal, PANEL)


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
    text = (EXAMPLES / "connectors.yaml").read_text().replace("{id: P1, end: a", "{id: P1, end: c")
    (tmp_path / "panel.yaml").write_text(text)
    with pytest.raises(PanelError, match="wire 'W1': connector 'P1': end is 'c'; allowed: a, b"):
        read_panel(tmp_path / "panel.yaml", read_wire_materials())
