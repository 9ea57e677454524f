"""How a wire that stands out of its ducts is tucked in: on a scripted device, drawn pictures."""

import inspect
import math
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np
import pytest
from laid_wires import LEGS, OVER_RIM_M, ROUTE, WIRE, laid, led, raised
from scripted_device import PARAMETERS, TICK_S

from remodel_skills.primitives.in_ducts import let_go, tuck_in
from remodel_states.fix_cable_state import FixCableState

FIXTURE, MOTION, TOOL = PARAMETERS.fixture, PARAMETERS.motion, PARAMETERS.tool
ROBOT, RIM_M = "robot_1", 0.060
# Of FixCable's time the clamp, the pull test and farther ways to the wire may take so much [s].
FIX_S = 20.0
# A wire that lies on the rim of a wall, and a hand that closes over the rims [m].
ON_RIM_M = RIM_M + 0.0028
# A hand that stopped early is so far above where it would have gone [m].
WELL_ABOVE_M = 0.016


def tucked(cell, **parameters):
    """Tuck the wire in; return the ducts that were tried, one after the other."""
    context, messages = cell.context, []
    groups = {name: replace(getattr(PARAMETERS, name), **new) for name, new in parameters.items()}
    context.parameters = replace(PARAMETERS, **groups)

    def watched():
        for _ in tuck_in(context):
            messages.append(context.progress.message)
            yield

    cell.run(watched())
    return [text.split("'")[1] for text, _ in groupby(messages) if text.startswith("tucking")]


def holding_hand(cell, gap=WIRE.diameter):
    """Let the fingers stop so far apart when they close, and return what they do."""
    cell.plant.grippers[ROBOT].stops_at = gap
    return cell.plant.trace[ROBOT]


def closings(trace):
    """Return the heights of the tool at which open fingers closed [m]."""
    return [tool.z for (_, was), (tool, gap) in pairwise(trace) if gap < was]


def while_closed(trace):
    return [tool for tool, gap in trace if gap <= WIRE.diameter]


def test_a_wire_that_stands_out_is_brought_down_between_the_walls_and_released():
    cell = laid(raised(led(), leg=2))
    trace = holding_hand(cell)
    assert tucked(cell, motion={"tucks_of_refused": 1}) == ["L"]
    lowest = min(while_closed(trace), key=lambda tool: tool.z)
    assert lowest.z == pytest.approx(FIXTURE.tuck_down_m, abs=1e-3)
    assert abs(lowest.y - ROUTE[2][1]) < 1e-3, "in the middle of the duct"
    (tool, gap) = trace[-1]
    assert gap >= 2 * TOOL.open_m and tool.z >= MOTION.travel_z_m


def test_a_wire_in_its_ducts_is_left_there():
    cell = laid(led())
    trace = holding_hand(cell)
    assert tucked(cell) == [] and not while_closed(trace)


@pytest.mark.parametrize(
    "tucks", [2, pytest.param(MOTION.tucks_of_refused, marks=pytest.mark.slow)]
)
def test_a_wire_that_would_be_refused_is_tucked_into_duct_after_duct_and_fixed_in_time(tucks):
    nodes = led()
    for leg in LEGS:
        nodes = raised(nodes, leg)
    cell = laid(nodes)
    trace = holding_hand(cell)
    ducts = tucked(cell, motion={"tucks_of_refused": tucks})
    allowed_s = inspect.signature(FixCableState).parameters["timeout_s"].default
    for_all_s = len(trace) * TICK_S * MOTION.tucks_of_refused / tucks
    assert for_all_s < allowed_s - FIX_S
    assert len(ducts) == tucks
    assert all(one != other for one, other in pairwise(ducts))


@pytest.mark.parametrize(
    ("aside", "goes_below"),
    [(-0.043, True), (-0.030, False), pytest.param(0.016, False, marks=pytest.mark.slow)],
    ids=["beside", "over the wall", "inside"],
)
def test_fingers_go_below_the_rim_only_where_both_are_beside_the_duct(aside, goes_below):
    cell = laid(raised(led(), 2, ON_RIM_M, aside))
    heights = closings(holding_hand(cell))
    tucked(cell, motion={"tucks_of_refused": 1}, fixture={"duct_least_share": 1.1})
    (height,) = closings(cell.plant.trace[ROBOT])
    over_rim = RIM_M + FIXTURE.tuck_over_rim_m + cell.context.fingers.below
    assert not heights
    if goes_below:
        assert height < over_rim - 5e-4
    else:
        assert height == pytest.approx(over_rim, abs=1e-4)


def test_a_wire_that_resists_is_brought_down_no_farther():
    cell = laid(raised(led(), leg=2))
    trace = holding_hand(cell)
    stiff_below_z = FIXTURE.tuck_down_m + 2 * WELL_ABOVE_M
    arm = cell.plant.arms[ROBOT]
    arm.feels = lambda tool: 2 * PARAMETERS.wire.tuck_most_n * (tool.z < stiff_below_z)
    tucked(cell, motion={"tucks_of_refused": 1})
    lowest = min(tool.z for tool in while_closed(trace))
    assert stiff_below_z - WELL_ABOVE_M < lowest < stiff_below_z
    tool, gap = trace[-1]
    assert gap >= 2 * TOOL.open_m and tool.z >= MOTION.travel_z_m


def test_fingers_that_close_beside_a_wire_press_nothing_down():
    cell = laid(raised(led(), leg=2))
    trace = holding_hand(cell, gap=0.0)
    assert tucked(cell, motion={"tucks_of_refused": 1}) == ["L"]
    assert min(tool.z for tool in while_closed(trace)) >= OVER_RIM_M - WELL_ABOVE_M / 4
    tool, gap = trace[-1]
    assert gap >= 2 * TOOL.open_m and tool.z >= MOTION.travel_z_m


def test_a_hand_that_lets_a_wire_go_sheds_it_to_both_sides_above_the_rims():
    cell = laid(led())
    context, trace = cell.context, cell.plant.trace[ROBOT]
    x, y, _ = (float(v) for v in (ROUTE[2] + ROUTE[3]) / 2)
    kept = replace(context.commanded, x=x, y=y, z=0.020, yaw=context.arm.base[3])
    context.drive(kept)
    context.drive_fingers(TOOL.eyelet_apart_m / 2)
    context.keeps_wire = True
    cell.run(let_go(context))
    across = np.array([-math.sin(kept.yaw), math.cos(kept.yaw), 0.0])
    beside = [(float((tool.position - kept.position) @ across), tool.z) for tool, _ in trace]
    far = max(FIXTURE.duct_asides_m)
    for side in (1, -1):
        aside, z = max(beside, key=lambda at: side * at[0])
        assert side * aside == pytest.approx(far, abs=1e-3)
        assert z - context.fingers.below > RIM_M, "the fingers are above the rims"
    aside, z = beside[-1]
    assert aside == pytest.approx(0.0, abs=1e-3) and z >= MOTION.travel_z_m - 1e-6
    assert trace[-1][1] >= 2 * TOOL.open_m and not context.keeps_wire
