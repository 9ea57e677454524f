"""A layout's wires as an order of the use case `switchgear`, for the simulated cell."""

from __future__ import annotations

import math

from remodel_planning.core.orders.work_order import Access, Route, Task, WorkOrder
from remodel_planning.core.problem.problem import End, PlannedArm, PlannedTerminal, Point
from remodel_production.core.panel.panel_layout import (
    CutWire,
    PanelLayout,
    PlacedChannel,
    PlacedComponent,
    PlacedTerminal,
)
from remodel_production.core.production import TerminalRef

USE_CASE = "switchgear"

# [m] height of the tool centre over the plate while end b is carried: clear of wires lying there,
# and low enough for the wire to stay in its channel.
CARRY_HEIGHT_M = 0.040

# [m] by which the tool goes past b's terminal, so that the wire bends back to it.
BEYOND_M = 0.030

# [m] height of the tool centre over the plate where a wire that is given up is released: it may
# fall across what lies there.
LAY_DOWN_HEIGHT_M = 0.028

# Of the cell (remodel_sim): the one arm stands before the panel, and changes no tools.
_ARM = "robot_1"
_TOOL = "gripper"
_HOME_MM = (-200, 0)
_REACH_MM = (-600, 600)


def cell_order(layout: PanelLayout) -> WorkOrder:
    """Return the order that places all wires of a layout, in the panel's frame."""
    openings = {
        TerminalRef(placed.component.name, terminal.name): (
            round(1e3 * (placed.x + terminal.x)),
            round(1e3 * (placed.y + terminal.y)),
        )
        for placed in layout.components
        for terminal in placed.terminals
    }
    channels = {channel.name: channel for channel in layout.channels}
    return WorkOrder(
        name=layout.name,
        use_case=USE_CASE,
        arms=(PlannedArm(_ARM, _HOME_MM, _REACH_MM, _HOME_MM, tool=_TOOL, holding=None),),
        components={placed.component.name: {} for placed in layout.components},
        terminals=tuple(
            PlannedTerminal(str(ref), ref.component, position) for ref, position in openings.items()
        ),
        access={
            str(TerminalRef(placed.component.name, terminal.name)): _access(placed, terminal)
            for placed in layout.components
            for terminal in placed.terminals
        },
        tasks=tuple(
            _task(cut, openings[cut.first], openings[cut.second], channels[cut.channel])
            for cut in layout.wires
        ),
    )


def _task(cut: CutWire, first: Point, second: Point, channel: PlacedChannel) -> Task:
    """Return the task of a wire; its end a is the one that the feeder lays beside its terminal."""
    middle = round(1e3 * channel.x)
    path = (first, (middle, first[1]), (middle, second[1]), second)
    return Task(
        name=cut.wire.name,
        terminals=(str(cut.first), str(cut.second)),
        slot_mm=first,
        characteristics={
            "section_mm2": cut.wire.section_mm2,
            "colour": cut.wire.colour,
            "channel": cut.channel,
            "left_end_mm": round(-1e3 * max(cut.first_y, cut.second_y)),
        },
        routes=(Route(path, segments=(cut.channel,)),),
        first=End.A,
        values=(
            ("carry_path", (_past_second(cut, channel, CARRY_HEIGHT_M),)),
            ("lay_down_pose", _past_second(cut, channel, LAY_DOWN_HEIGHT_M)),
        ),
    )


def _access(placed: PlacedComponent, terminal: PlacedTerminal) -> Access:
    design = placed.component.terminal(terminal.name)
    return Access(approach=design.approach, kind=placed.component.type_of(design))


def _past_second(cut: CutWire, channel: PlacedChannel, height_m: float) -> tuple[float, ...]:
    """Return the tool pose [x, y, z, yaw] in the channel, past the second terminal."""
    onwards = 1 if cut.second_y >= cut.first_y else -1
    y = cut.second_y + onwards * BEYOND_M
    return (round(channel.x, 4), round(y, 4), height_m, round(onwards * math.pi / 2, 4))
