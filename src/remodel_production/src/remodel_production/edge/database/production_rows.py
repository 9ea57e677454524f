"""Orders and their preferences to rows and back: the codec of the production database.

Rows are read table by table for a whole product, so that an order of a thousand wires takes a dozen
queries.

The document of preferences (docs/planning.md) has sections; each entry of a section is a row:
of `require` among the constraints, of any other one among the preferences.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from sqlalchemy import insert, select
from sqlalchemy.engine import Connection, Row

from remodel_production.core.production import (
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
from remodel_production.edge.database.production_models import (
    CableRow,
    ClipRow,
    ComponentRow,
    ConstraintRow,
    NodeRow,
    NoteRow,
    OrderRow,
    PreferenceRow,
    ProductRow,
    RouteRow,
    SegmentRow,
    TaskRow,
    TerminalRow,
    WireRow,
)
from remodel_production.errors import OrderError

_Columns = dict[str, Any]
# A mapped class; they have no common type.
_Table = Any


def add_order_rows(connection: Connection, order: Order) -> int:
    """Add an order with its product, and an open task for each wire that lies in the cabinet.

    Returns:
        The number of the order's row.
    """
    product = _added(connection, ProductRow, {"title": order.title, "source": order.source})
    of = {"product_id": product}
    _add(connection, NoteRow, ({"text": text, **of} for text in order.notes))
    _add(connection, NodeRow, ({"name": n.name, **_at(n.position), **of} for n in order.nodes))
    nodes = _numbers(connection, NodeRow, product)
    _add(connection, SegmentRow, (_segment_row(s, nodes, of) for s in order.segments))
    segments = _numbers(connection, SegmentRow, product)
    _add(connection, ClipRow, (_clip_row(clip, segments, nodes, of) for clip in order.clips))
    _add(connection, CableRow, ({**asdict(cable), **of} for cable in order.cables))
    cables = _numbers(connection, CableRow, product)
    _add(connection, ComponentRow, (_component_row(c, nodes, of) for c in order.components))
    components = _numbers(connection, ComponentRow, product)
    _add(
        connection,
        TerminalRow,
        (
            _terminal_row(terminal, components[component.name])
            for component in order.components
            for terminal in component.terminals
        ),
    )
    terminals = _terminal_numbers(connection, product)
    _add(connection, WireRow, (_wire_row(wire, terminals, cables, of) for wire in order.wires))
    wires = _numbers(connection, WireRow, product)
    _add(
        connection,
        RouteRow,
        (
            {"wire_id": wires[wire.name], "position": i, "segment_id": segments[name]}
            for wire in order.wires
            for i, name in enumerate(wire.route)
        ),
    )
    number = _added(connection, OrderRow, {"name": order.name, **of})
    _add(
        connection,
        TaskRow,
        (
            {"order_id": number, "wire_id": wires[wire.name], "state": "open", "cell": ""}
            for wire in order.in_cabinet().wires
        ),
    )
    return number


def order_of_row(connection: Connection, row: Row) -> Order:
    """Return the order of a row."""
    of_product = select(ProductRow).where(ProductRow.id == row.product_id)
    product = connection.execute(of_product).one()

    def rows(table: _Table) -> list[Row]:
        query = select(table).where(table.product_id == product.id).order_by(table.id)
        return connection.execute(query).all()

    nodes = {node.id: node.name for node in rows(NodeRow)}
    segments = {segment.id: segment for segment in rows(SegmentRow)}
    cables = {cable.id: cable for cable in rows(CableRow)}
    components = {component.id: component for component in rows(ComponentRow)}
    terminals = connection.execute(
        select(TerminalRow)
        .join(ComponentRow, TerminalRow.component_id == ComponentRow.id)
        .where(ComponentRow.product_id == product.id)
        .order_by(TerminalRow.id)
    ).all()
    of_component: dict[int, list[Terminal]] = defaultdict(list)
    for terminal in terminals:
        of_component[terminal.component_id].append(_terminal(terminal))
    refs = {t.id: TerminalRef(components[t.component_id].name, t.name) for t in terminals}
    routes: dict[int, list[str]] = defaultdict(list)
    for step in connection.execute(
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
        wires=tuple(
            Wire(
                wire.name,
                refs[wire.a_terminal_id],
                refs[wire.b_terminal_id],
                wire.colour,
                section_mm2=wire.section_mm2,
                source=wire.source,
                length_m=wire.length_m,
                cable="" if wire.cable_id is None else cables[wire.cable_id].name,
                core=wire.core,
                route=tuple(routes[wire.id]),
                number=wire.number,
            )
            for wire in rows(WireRow)
        ),
        notes=tuple(note.text for note in rows(NoteRow)),
        cables=tuple(
            Cable(c.name, c.kind, c.length_m, c.shielded, source=c.source) for c in cables.values()
        ),
        nodes=tuple(Node(node.name, _position(node)) for node in rows(NodeRow)),
        segments=tuple(
            Segment(
                s.name,
                nodes[s.start_node_id],
                nodes[s.end_node_id],
                s.length_m,
                kind=SegmentKind(s.kind),
            )
            for s in segments.values()
        ),
        clips=tuple(
            Clip(
                clip.name,
                clip.kind,
                "" if clip.segment_id is None else segments[clip.segment_id].name,
                clip.along,
                node=nodes.get(clip.node_id, ""),
                position=_position(clip),
            )
            for clip in rows(ClipRow)
        ),
    )


def _added(connection: Connection, table: _Table, values: _Columns) -> int:
    """Add a row, and return its number."""
    (number,) = connection.execute(insert(table), values).inserted_primary_key
    return number


def _add(connection: Connection, table: _Table, rows: Iterable[_Columns]) -> None:
    """Add rows that have the same columns."""
    values = list(rows)
    if values:
        connection.execute(insert(table), values)


def _numbers(connection: Connection, table: _Table, product: int) -> dict[str, int]:
    """Return the numbers of a product's rows by name."""
    asked = select(table.name, table.id).where(table.product_id == product)
    return dict(connection.execute(asked).all())


def _terminal_numbers(connection: Connection, product: int) -> dict[TerminalRef, int]:
    asked = (
        select(ComponentRow.name, TerminalRow.name, TerminalRow.id)
        .join(ComponentRow, TerminalRow.component_id == ComponentRow.id)
        .where(ComponentRow.product_id == product)
    )
    return {TerminalRef(*names): number for *names, number in connection.execute(asked)}


def _segment_row(segment: Segment, nodes: Mapping[str, int], of: _Columns) -> _Columns:
    return {
        "name": segment.name,
        "kind": segment.kind.value,
        "start_node_id": nodes[segment.start],
        "end_node_id": nodes[segment.end],
        "length_m": segment.length_m,
        **of,
    }


def _clip_row(
    clip: Clip, segments: Mapping[str, int], nodes: Mapping[str, int], of: _Columns
) -> _Columns:
    return {
        "name": clip.name,
        "kind": clip.kind,
        "segment_id": segments.get(clip.segment),
        "along": clip.along,
        "node_id": nodes.get(clip.node),
        **_at(clip.position),
        **of,
    }


def _component_row(component: Component, nodes: Mapping[str, int], of: _Columns) -> _Columns:
    return {
        "name": component.name,
        "kind": component.kind,
        "role": component.role.value,
        "part_number": component.part_number,
        "mount": component.mount.value,
        "node_id": nodes.get(component.node),
        **_posed(component.pose),
        **of,
    }


def _terminal_row(terminal: Terminal, component_id: int) -> _Columns:
    x, y, z = terminal.approach or (None, None, None)
    return {
        "component_id": component_id,
        "name": terminal.name,
        "side": terminal.side.value,
        "point": terminal.point,
        "kind": terminal.kind,
        "approach_x": x,
        "approach_y": y,
        "approach_z": z,
        "clearance_m": terminal.clearance_m,
        "insertion_force_limit_n": terminal.insertion_force_limit_n,
        **_posed(terminal.pose),
    }


def _wire_row(
    wire: Wire, terminals: Mapping[TerminalRef, int], cables: Mapping[str, int], of: _Columns
) -> _Columns:
    return {
        "name": wire.name,
        "number": wire.number,
        "a_terminal_id": terminals[wire.a],
        "b_terminal_id": terminals[wire.b],
        "colour": wire.colour,
        "section_mm2": wire.section_mm2,
        "length_m": wire.length_m,
        "cable_id": cables.get(wire.cable),
        "core": wire.core,
        "source": wire.source,
        **of,
    }


def _component(row: Row, terminals: list[Terminal], nodes: Mapping[int, str]) -> Component:
    return Component(
        row.name,
        row.kind,
        tuple(terminals),
        Mount(row.mount),
        role=Role(row.role),
        part_number=row.part_number,
        pose=_pose(row),
        node=nodes.get(row.node_id, ""),
    )


def _terminal(row: Row) -> Terminal:
    approach = (row.approach_x, row.approach_y, row.approach_z)
    return Terminal(
        row.name,
        Side(row.side),
        row.point,
        row.kind,
        pose=_pose(row),
        approach=None if row.approach_x is None else approach,
        clearance_m=row.clearance_m,
        insertion_force_limit_n=row.insertion_force_limit_n,
    )


def _at(position: Vector | None) -> _Columns:
    x, y, z = position or (None, None, None)
    return {"x_m": x, "y_m": y, "z_m": z}


def _posed(pose: Pose | None) -> _Columns:
    qx, qy, qz, qw = pose.orientation if pose else (None, None, None, None)
    return {**_at(pose.position if pose else None), "qx": qx, "qy": qy, "qz": qz, "qw": qw}


def _position(row: Row) -> Vector | None:
    return None if row.x_m is None else (row.x_m, row.y_m, row.z_m)


def _pose(row: Row) -> Pose | None:
    position = _position(row)
    return None if position is None else Pose(position, (row.qx, row.qy, row.qz, row.qw))


_REQUIRE = "require"


def add_preference_rows(connection: Connection, order_id: int, document: object) -> None:
    """Add the rows of an order's preferences; none for no document.

    Raises:
        OrderError: if the document has no sections.
    """
    if document is None:
        return
    if not isinstance(document, dict):
        raise OrderError(
            f"the preferences are a {type(document).__name__}; sections are needed: prefer, "
            "require, weights"
        )
    for section, entries in document.items():
        is_mapping = isinstance(entries, dict)
        rules = [{key: entries[key]} for key in entries] if is_mapping else entries
        if not isinstance(rules, list):
            rules = [rules]
        table = ConstraintRow if section == _REQUIRE else PreferenceRow
        rows = [
            {
                "order_id": order_id,
                "section": str(section),
                "position": position,
                "name": str(rule.get("name", "")) if isinstance(rule, dict) else "",
                "rule": {"entry": rule, "of": type(entries).__name__},
            }
            for position, rule in enumerate(rules)
        ]
        if rows:
            connection.execute(insert(table), rows)


def preferences_of_rows(connection: Connection, order_id: int) -> dict[str, Any] | None:
    """Return the document of an order's preferences, None if it has none."""
    document: dict[str, Any] = {}
    for table in (PreferenceRow, ConstraintRow):
        asked = select(table).where(table.order_id == order_id).order_by(table.id)
        for row in connection.execute(asked):
            entry = row.rule["entry"]
            if row.rule["of"] == "dict":
                document.setdefault(row.section, {}).update(entry)
            elif row.rule["of"] == "list":
                document.setdefault(row.section, []).append(entry)
            else:
                document[row.section] = entry
    return document or None
