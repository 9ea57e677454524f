"""Orders to rows and back: the codec of the production knowledge database.

Rows are read table by table for a whole product, so that an order of a thousand wires takes a dozen
queries.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from remodel_planner.core.production import (
    Cable,
    Clip,
    Component,
    Mount,
    Node,
    Order,
    Pose,
    Role,
    Segment,
    SegmentKind,
    Side,
    Terminal,
    TerminalRef,
    Vector,
    Wire,
)
from remodel_planner.edge.production_models import (
    CableRow,
    ClipRow,
    ComponentRow,
    NodeRow,
    NoteRow,
    OrderRow,
    ProductRow,
    RouteRow,
    SegmentRow,
    TaskRow,
    TerminalRow,
    WireRow,
)

_Columns = dict[str, Any]


def add_order_rows(session: Session, order: Order) -> OrderRow:
    """Add an order with its product, and an open task for each wire that lies in the cabinet."""
    product = ProductRow(title=order.title, source=order.source)
    session.add(product)
    session.flush()
    of = {"product_id": product.id}
    session.bulk_insert_mappings(NoteRow, [{"text": text, **of} for text in order.notes])
    nodes = _added(
        session, {n.name: NodeRow(name=n.name, **_at(n.position), **of) for n in order.nodes}
    )
    segments = _added(
        session,
        {
            segment.name: SegmentRow(
                name=segment.name,
                kind=segment.kind.value,
                start_node_id=nodes[segment.start],
                end_node_id=nodes[segment.end],
                length_m=segment.length_m,
                **of,
            )
            for segment in order.segments
        },
    )
    session.add_all(_clip_row(clip, segments, nodes, of) for clip in order.clips)
    cables = _added(
        session,
        {
            cable.name: CableRow(
                name=cable.name,
                kind=cable.kind,
                length_m=cable.length_m,
                shielded=cable.shielded,
                source=cable.source,
                **of,
            )
            for cable in order.cables
        },
    )
    terminals = _add_components(session, order, nodes, of)
    wires = _added(
        session,
        {wire.name: _wire_row(wire, terminals, cables, of) for wire in order.wires},
    )
    session.bulk_insert_mappings(
        RouteRow,
        [
            {"wire_id": wires[wire.name], "position": i, "segment_id": segments[name]}
            for wire in order.wires
            for i, name in enumerate(wire.route)
        ],
    )
    row = OrderRow(name=order.name, product_id=product.id)
    session.add(row)
    session.flush()
    session.bulk_insert_mappings(
        TaskRow,
        [
            {"order_id": row.id, "wire_id": wires[wire.name], "state": "open", "cell": ""}
            for wire in order.in_cabinet().wires
        ],
    )
    return row


def order_of_row(session: Session, row: OrderRow) -> Order:
    """Return the order of a row."""
    product = session.get(ProductRow, row.product_id)

    def rows(table: Any) -> list[Any]:  # noqa: ANN401 - the mapped classes have no common type
        query = select(table).filter_by(product_id=product.id).order_by(table.id)
        return list(session.scalars(query))

    nodes = {node.id: node.name for node in rows(NodeRow)}
    segments = {segment.id: segment for segment in rows(SegmentRow)}
    cables = {cable.id: cable for cable in rows(CableRow)}
    components = {component.id: component for component in rows(ComponentRow)}
    terminals = list(
        session.scalars(
            select(TerminalRow)
            .join(ComponentRow, TerminalRow.component_id == ComponentRow.id)
            .where(ComponentRow.product_id == product.id)
            .order_by(TerminalRow.id)
        )
    )
    of_component: dict[int, list[Terminal]] = defaultdict(list)
    for terminal in terminals:
        of_component[terminal.component_id].append(_terminal(terminal))
    refs = {t.id: TerminalRef(components[t.component_id].name, t.name) for t in terminals}
    routes: dict[int, list[str]] = defaultdict(list)
    for step in session.scalars(
        select(RouteRow)
        .join(WireRow, RouteRow.wire_id == WireRow.id)
        .where(WireRow.product_id == product.id)
        .order_by(RouteRow.wire_id, RouteRow.position)
    ):
        routes[step.wire_id].append(segments[step.segment_id].name)
    return Order(
        row.name,
        product.title,
        product.source,
        tuple(_component(c, of_component[c.id], nodes) for c in components.values()),
        tuple(
            Wire(
                wire.name,
                refs[wire.a_terminal_id],
                refs[wire.b_terminal_id],
                wire.colour,
                wire.section_mm2,
                wire.source,
                wire.length_m,
                "" if wire.cable_id is None else cables[wire.cable_id].name,
                wire.core,
                tuple(routes[wire.id]),
            )
            for wire in rows(WireRow)
        ),
        tuple(note.text for note in rows(NoteRow)),
        tuple(Cable(c.name, c.kind, c.length_m, c.shielded, c.source) for c in cables.values()),
        tuple(Node(node.name, _position(node)) for node in rows(NodeRow)),
        tuple(
            Segment(
                s.name,
                nodes[s.start_node_id],
                nodes[s.end_node_id],
                s.length_m,
                SegmentKind(s.kind),
            )
            for s in segments.values()
        ),
        tuple(
            Clip(
                clip.name,
                clip.kind,
                "" if clip.segment_id is None else segments[clip.segment_id].name,
                clip.along,
                nodes.get(clip.node_id, ""),
                _position(clip),
            )
            for clip in rows(ClipRow)
        ),
    )


def _added(session: Session, rows: Mapping[str, Any]) -> dict[str, int]:
    """Add rows, and return their numbers by name."""
    session.add_all(rows.values())
    session.flush()
    return {name: row.id for name, row in rows.items()}


def _add_components(
    session: Session, order: Order, nodes: dict[str, int], of: _Columns
) -> dict[TerminalRef, int]:
    components = _added(
        session,
        {
            component.name: ComponentRow(
                name=component.name,
                kind=component.kind,
                role=component.role.value,
                part_number=component.part_number,
                mount=component.mount.value,
                node_id=nodes.get(component.node),
                **_posed(component.pose),
                **of,
            )
            for component in order.components
        },
    )
    rows = {
        TerminalRef(component.name, terminal.name): _terminal_row(
            terminal, components[component.name]
        )
        for component in order.components
        for terminal in component.terminals
    }
    session.add_all(rows.values())
    session.flush()
    return {ref: row.id for ref, row in rows.items()}


def _terminal_row(terminal: Terminal, component_id: int) -> TerminalRow:
    x, y, z = terminal.approach or (None, None, None)
    return TerminalRow(
        component_id=component_id,
        name=terminal.name,
        side=terminal.side.value,
        point=terminal.point,
        kind=terminal.kind,
        approach_x=x,
        approach_y=y,
        approach_z=z,
        clearance_m=terminal.clearance_m,
        insertion_force_limit_n=terminal.insertion_force_limit_n,
        **_posed(terminal.pose),
    )


def _wire_row(
    wire: Wire, terminals: dict[TerminalRef, int], cables: dict[str, int], of: _Columns
) -> WireRow:
    return WireRow(
        name=wire.name,
        a_terminal_id=terminals[wire.a],
        b_terminal_id=terminals[wire.b],
        colour=wire.colour,
        section_mm2=wire.section_mm2,
        length_m=wire.length_m,
        cable_id=cables.get(wire.cable),
        core=wire.core,
        source=wire.source,
        **of,
    )


def _clip_row(clip: Clip, segments: dict[str, int], nodes: dict[str, int], of: _Columns) -> ClipRow:
    return ClipRow(
        name=clip.name,
        kind=clip.kind,
        segment_id=segments.get(clip.segment),
        along=clip.along,
        node_id=nodes.get(clip.node),
        **_at(clip.position),
        **of,
    )


def _component(row: ComponentRow, terminals: list[Terminal], nodes: dict[int, str]) -> Component:
    return Component(
        row.name,
        row.kind,
        tuple(terminals),
        Mount(row.mount),
        Role(row.role),
        row.part_number,
        _pose(row),
        nodes.get(row.node_id, ""),
    )


def _terminal(row: TerminalRow) -> Terminal:
    approach = (row.approach_x, row.approach_y, row.approach_z)
    return Terminal(
        row.name,
        Side(row.side),
        row.point,
        row.kind,
        _pose(row),
        None if row.approach_x is None else approach,
        row.clearance_m,
        row.insertion_force_limit_n,
    )


def _at(position: Vector | None) -> _Columns:
    x, y, z = position or (None, None, None)
    return {"x_m": x, "y_m": y, "z_m": z}


def _posed(pose: Pose | None) -> _Columns:
    if pose is None:
        return {}
    qx, qy, qz, qw = pose.orientation
    return {**_at(pose.position), "qx": qx, "qy": qy, "qz": qz, "qw": qw}


def _position(row: NodeRow | ClipRow | ComponentRow | TerminalRow) -> Vector | None:
    return None if row.x_m is None else (row.x_m, row.y_m, row.z_m)


def _pose(row: ComponentRow | TerminalRow) -> Pose | None:
    position = _position(row)
    return None if position is None else Pose(position, (row.qx, row.qy, row.qz, row.qw))
