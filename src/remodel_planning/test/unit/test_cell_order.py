"""The demo's wires are planned as its use case prefers them."""

from pathlib import Path

import pytest

from remodel_planning.core.decomposition.preparation import prepare
from remodel_planning.core.orders.cell_order import BEYOND_M, CARRY_HEIGHT_M, USE_CASE, cell_order
from remodel_planning.core.task_charts.planned_tasks import planned_tasks
from remodel_planning.edge.order_planner import plan_problem
from remodel_planning.edge.use_case_files import find_use_case
from remodel_production.core.imports.qet import import_qet
from remodel_production.core.panel.panel_layout import PanelRules, lay_out
from remodel_production.edge.catalogue_file import read_catalogue

CATALOGUE = read_catalogue(
    Path(__file__).parents[3] / "remodel_production" / "config" / "catalogue.yaml"
)
DESIGN = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")


def layout_of(wires):
    order = import_qet(DESIGN.read_bytes(), "demo", DESIGN.name, CATALOGUE).order.in_cabinet()
    return lay_out(order.first(wires), CATALOGUE, PanelRules())


@pytest.mark.parametrize("wires", [1, 6, 20])
def test_thick_wires_come_first_then_channel_by_channel_from_right_to_left(wires):
    layout = layout_of(wires)
    prepared = prepare(cell_order(layout), find_use_case(USE_CASE))
    planned = plan_problem(prepared.preferred.problem, 0.3)
    rank = {
        cut.wire.name: (
            -cut.wire.section_mm2,
            cut.channel,
            round(1e3 * max(cut.first_y, cut.second_y)),
        )
        for cut in layout.wires
    }
    ranks = [rank[task.name] for task in planned_tasks(prepared, planned.plan)]
    assert ranks == sorted(rank.values())


def test_the_end_is_carried_along_the_channel_past_its_terminal():
    layout = layout_of(6)
    for cut, task in zip(layout.wires, cell_order(layout).tasks, strict=True):
        ((x, y, z, yaw),) = dict(task.values)["carry_path"]
        channel = next(c for c in layout.channels if c.name == cut.channel)
        assert x == pytest.approx(channel.x, abs=1e-4)
        assert abs(y - cut.second_y) == pytest.approx(BEYOND_M)
        assert (z, (yaw > 0)) == (CARRY_HEIGHT_M, cut.second_y >= cut.first_y)
        assert task.terminals == (str(cut.first), str(cut.second))
