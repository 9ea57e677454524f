"""Translate a panel layout into remodel_msgs/Panel."""

from __future__ import annotations

from geometry_msgs.msg import Point, Pose2D, Vector3
from remodel_msgs.msg import Channel, Component, Panel, Terminal, Wire

from remodel_production.core.panel.panel_layout import (
    CutWire,
    PanelLayout,
    PanelRules,
    PlacedChannel,
    PlacedComponent,
    PlacedTerminal,
)

_PLATE_THICKNESS_M = 0.003  # usual for mounting plates; the robot works on its surface


def panel_message(layout: PanelLayout, rules: PanelRules) -> Panel:
    """Return the message for a layout that was made by these rules."""
    return Panel(
        name=layout.name,
        size=Vector3(layout.depth, layout.width, _PLATE_THICKNESS_M),
        components=[_component(placed, rules) for placed in layout.components],
        channels=[_channel(channel) for channel in layout.channels],
        wires=[_wire(cut) for cut in layout.wires],
    )


def _component(placed: PlacedComponent, rules: PanelRules) -> Component:
    return Component(
        id=placed.component.name,
        kind=placed.component.kind,
        marker_id=placed.marker_id,
        marker_size=rules.marker_size,
        pose=Pose2D(placed.x, placed.y, 0.0),
        size=Vector3(placed.depth, placed.width, placed.height),
        terminals=[_terminal(terminal, rules) for terminal in placed.terminals],
    )


def _terminal(terminal: PlacedTerminal, rules: PanelRules) -> Terminal:
    return Terminal(
        id=terminal.name,
        mouth=Point(terminal.x, terminal.y, terminal.z),
        insertion_yaw=terminal.insertion_yaw,
        bore=terminal.bore,
        depth=terminal.depth,
        chamfer=rules.chamfer,
        retention_force=rules.retention_force,
    )


def _channel(channel: PlacedChannel) -> Channel:
    return Channel(
        id=channel.name,
        x=channel.x,
        width=channel.width,
        y_min=channel.y_min,
        y_max=channel.y_max,
    )


def _wire(cut: CutWire) -> Wire:
    return Wire(
        id=cut.wire.name,
        a_component=cut.first.component,
        a_terminal=cut.first.terminal,
        b_component=cut.second.component,
        b_terminal=cut.second.terminal,
        colour=cut.wire.colour,
        section=cut.wire.section_mm2,
        diameter=cut.type.diameter_m,
        length=cut.length,
        linear_density=cut.type.density_kg_m,
        bending_stiffness=cut.type.stiffness_n_m2,
        ferrule_length=cut.type.ferrule_m,
    )
