"""Products apart from orders; places, routes, cables, tasks, preferences, abilities."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

# Of version 0001, in an order in which each can be dropped before those it refers to.
_OLD_TABLES = (
    "ability_records",
    "executions",
    "runs",
    "notes",
    "wires",
    "terminals",
    "components",
    "orders",
)
_Row = dict[str, Any]


def upgrade() -> None:
    """Read the old rows, make the new tables in place of the old ones, and write the rows again."""
    old = {table: _rows(table) for table in _OLD_TABLES}
    for table in _OLD_TABLES:
        op.drop_table(table)
    _create_tables()
    for table, rows in _moved(old).items():
        _insert(table, rows)


def _rows(table: str) -> list[_Row]:
    found = _table(table)
    return [
        dict(row) for row in op.get_bind().execute(found.select().order_by(found.c.id)).mappings()
    ]


def _table(name: str) -> sa.Table:
    return sa.Table(name, sa.MetaData(), autoload_with=op.get_bind())


def _insert(table: str, rows: list[_Row]) -> None:
    """Insert rows under their old numbers, and let new ones be counted from there."""
    connection = op.get_bind()
    if rows:
        connection.execute(_table(table).insert(), rows)
        if connection.dialect.name == "postgresql":
            connection.execute(
                sa.text(
                    f"SELECT setval(pg_get_serial_sequence('{table}', 'id'), max(id)) FROM {table}"
                )
            )


def _moved(old: dict[str, list[_Row]]) -> dict[str, list[_Row]]:
    """Return the new rows: each order had a design, and each of its wires becomes a task."""
    order_of_wire = {row["id"]: row["order_id"] for row in old["wires"]}
    placed = {
        wire: any(run["placed"] for run in old["executions"] if run["wire_id"] == wire)
        for wire in {row["wire_id"] for row in old["executions"]}
    }
    states = {wire: "placed" if is_placed else "failed" for wire, is_placed in placed.items()}
    return {
        "products": [
            {"id": row["id"], "title": row["title"], "source": row["source"]}
            for row in old["orders"]
        ],
        "orders": [
            {"id": row["id"], "name": row["name"], "product_id": row["id"]} for row in old["orders"]
        ],
        "notes": [_of_product(row) for row in old["notes"]],
        "components": [
            _of_product(row) | {"role": "device", "part_number": "", "mount": "plate"}
            for row in old["components"]
        ],
        "terminals": [row | {"kind": ""} for row in old["terminals"]],
        "wires": [_of_product(row) | {"core": ""} for row in old["wires"]],
        "tasks": [
            {
                "id": wire,
                "order_id": order,
                "wire_id": wire,
                "state": states.get(wire, "open"),
            }
            for wire, order in order_of_wire.items()
        ],
        "runs": old["runs"],
        "executions": [
            _without(row, "wire_id") | {"task_id": row["wire_id"]} for row in old["executions"]
        ],
        "ability_records": old["ability_records"],
    }


def _of_product(row: _Row) -> _Row:
    return _without(row, "order_id") | {"product_id": row["order_id"]}


def _without(row: _Row, key: str) -> _Row:
    return {name: value for name, value in row.items() if name != key}


def _key() -> sa.Column:
    return sa.Column("id", sa.Integer, primary_key=True, comment="number of the row")


def _of(
    table: str, name: str, comment: str, *, optional: bool = False, key: bool = False
) -> sa.Column:
    return sa.Column(
        name,
        sa.Integer,
        sa.ForeignKey(f"{table}.id", ondelete="CASCADE"),
        nullable=optional,
        primary_key=key,
        index=not key,
        comment=comment,
    )


def _text(name: str, comment: str) -> sa.Column:
    return sa.Column(name, sa.String, nullable=False, comment=comment)


def _number(name: str, comment: str) -> sa.Column:
    return sa.Column(name, sa.Float, nullable=True, comment=comment)


def _create(table: str, comment: str, *columns: sa.schema.SchemaItem, has_id: bool = True) -> None:
    key = (_key(),) if has_id else ()
    op.create_table(table, *key, *columns, comment=comment)


def _create_tables() -> None:
    _create(
        "abilities",
        "what the cell can do, by its actions",
        _text("name", "of the action, such as InsertCable"),
        _text("description", "what it does, for a person"),
        sa.UniqueConstraint("name"),
    )
    _create(
        "products",
        "what is built: a cabinet or a harness, as one design file tells it",
        _text("title", "of the design; empty if it has none"),
        _text("source", "name of the design file"),
    )
    _create(
        "ability_parameters",
        "what a goal tells an ability",
        _of("abilities", "ability_id", "that takes it"),
        sa.Column("position", sa.Integer, nullable=False, comment="in the goal, from 0"),
        _text("name", "of the goal's field"),
        _text("type", "of the goal's field, as ROS messages name it"),
        _text("description", "with unit and frame, for a person"),
        sa.UniqueConstraint("ability_id", "name"),
    )
    _create(
        "cables",
        "cables, whose cores and shields are wires",
        _of("products", "product_id", "that it is part of"),
        _text("name", "unique in the product"),
        _text("kind", "its type or article; empty if it is not known"),
        _number("length_m", "[m]; null if it is not known"),
        sa.Column("shielded", sa.Boolean, nullable=False, comment="whether it has a shield"),
        _text("source", "place in the design file"),
        sa.UniqueConstraint("product_id", "name"),
    )
    _create(
        "nodes",
        "where segments meet or end",
        _of("products", "product_id", "that the node is of"),
        _text("name", "unique in the product"),
        _number("x_m", "[m] place in the product's frame; null if it is not known"),
        _number("y_m", "[m] place in the product's frame; null if it is not known"),
        _number("z_m", "[m] place in the product's frame; null if it is not known"),
        sa.UniqueConstraint("product_id", "name"),
    )
    _create(
        "notes",
        "what the import of a product guessed and left out",
        _of("products", "product_id", "that was imported"),
        _text("text", "one line, with its place in the design file"),
    )
    _create(
        "orders",
        "what is to be built now",
        _text("name", "by which people call the order"),
        _of("products", "product_id", "that is to be built"),
        sa.UniqueConstraint("name"),
    )
    _create(
        "components",
        "devices with clamps and connectors with cavities",
        _of("products", "product_id", "that it is part of"),
        _text("name", "designation, unique in the product"),
        _text("kind", "what it is, for a person"),
        _text("role", "device or connector"),
        _text("part_number", "of its article; empty if it is not known"),
        _text("mount", "plate (in the cabinet, or on the board) or field (outside)"),
        _of("nodes", "node_id", "of the routes at which it sits; null if at none", optional=True),
        _number("x_m", "[m] place in the product's frame; null if it is not known"),
        _number("y_m", "[m] place in the product's frame; null if it is not known"),
        _number("z_m", "[m] place in the product's frame; null if it is not known"),
        _number("qx", "unit quaternion of its frame in the product's; null if it is not known"),
        _number("qy", "unit quaternion of its frame in the product's; null if it is not known"),
        _number("qz", "unit quaternion of its frame in the product's; null if it is not known"),
        _number("qw", "unit quaternion of its frame in the product's; null if it is not known"),
        sa.UniqueConstraint("product_id", "name"),
    )
    _create(
        "constraints",
        "what the user requires of an order's plan; no plan breaks it",
        _of("orders", "order_id", "whose plan it is about"),
        _text("section", "of the preferences' document: require"),
        sa.Column("position", sa.Integer, nullable=False, comment="in its section, from 0"),
        _text("name", "the user's name for it; empty if it has none"),
        sa.Column("rule", sa.JSON, nullable=False, comment="the entry, as in the document"),
        sa.UniqueConstraint("order_id", "section", "position"),
    )
    _create(
        "preferences",
        "what the user prefers of an order's plan; a plan may break it, and pays",
        _of("orders", "order_id", "whose plan it is about"),
        _text("section", "of the preferences' document: prefer, or weights"),
        sa.Column("position", sa.Integer, nullable=False, comment="in its section, from 0"),
        _text("name", "the user's name for it; empty if it has none"),
        sa.Column("rule", sa.JSON, nullable=False, comment="the entry, as in the document"),
        sa.UniqueConstraint("order_id", "section", "position"),
    )
    _create(
        "runs",
        "attempts to build an order, or part of it",
        _of("orders", "order_id", "that was run"),
        sa.Column("started", sa.DateTime, nullable=False, comment="wall time, UTC"),
    )
    _create(
        "segments",
        "pieces of the ways of wires, between two nodes",
        _of("products", "product_id", "that the segment is of"),
        _text("name", "unique in the product"),
        _text("kind", "duct (of a cabinet) or bundle (of wires)"),
        _of("nodes", "start_node_id", "where it starts"),
        _of("nodes", "end_node_id", "where it ends"),
        sa.Column("length_m", sa.Float, nullable=False, comment="[m] along its course"),
        sa.CheckConstraint("length_m >= 0", name="length"),
        sa.UniqueConstraint("product_id", "name"),
    )
    _create(
        "clips",
        "what holds the wires that pass it, on a segment or at a node",
        _of("products", "product_id", "that the clip is of"),
        _text("name", "unique in the product"),
        _text("kind", "its type, for a person; empty if it is not known"),
        _of("segments", "segment_id", "that it sits on; null if at a node", optional=True),
        sa.Column(
            "along", sa.Float, nullable=False, comment="place on the segment, 0 at its start to 1"
        ),
        _of("nodes", "node_id", "that it sits at; null if on a segment", optional=True),
        _number("x_m", "[m] place in the product's frame; null if it is not known"),
        _number("y_m", "[m] place in the product's frame; null if it is not known"),
        _number("z_m", "[m] place in the product's frame; null if it is not known"),
        sa.CheckConstraint("along >= 0 AND along <= 1", name="along"),
        sa.CheckConstraint("(segment_id IS NULL) <> (node_id IS NULL)", name="place"),
        sa.UniqueConstraint("product_id", "name"),
    )
    _create(
        "terminals",
        "clamps of devices and cavities of connectors, each for one wire end",
        _of("components", "component_id", "that it is part of"),
        _text("name", "unique in the component"),
        _text("side", "top or bottom, on which it opens as drawn"),
        _text("point", "of the drawing that it shares with other terminals; empty if with none"),
        _text("kind", "its type, such as the article of the contact; empty if it is not known"),
        _number("x_m", "[m] place of its mouth in the component's frame; null if it is not known"),
        _number("y_m", "[m] place of its mouth in the component's frame; null if it is not known"),
        _number("z_m", "[m] place of its mouth in the component's frame; null if it is not known"),
        _number("qx", "unit quaternion of its frame in the component's; null if it is not known"),
        _number("qy", "unit quaternion of its frame in the component's; null if it is not known"),
        _number("qz", "unit quaternion of its frame in the component's; null if it is not known"),
        _number("qw", "unit quaternion of its frame in the component's; null if it is not known"),
        _number(
            "approach_x",
            "unit vector by which an end goes in, component's frame; null if it is not known",
        ),
        _number(
            "approach_y",
            "unit vector by which an end goes in, component's frame; null if it is not known",
        ),
        _number(
            "approach_z",
            "unit vector by which an end goes in, component's frame; null if it is not known",
        ),
        _number(
            "clearance_m", "[m] that a gripper needs around the mouth; null if it is not known"
        ),
        _number(
            "insertion_force_limit_n",
            "[N] that an insertion must not exceed; null if it is not known",
        ),
        sa.CheckConstraint("clearance_m >= 0", name="clearance"),
        sa.CheckConstraint("insertion_force_limit_n > 0", name="insertion_force_limit"),
        sa.UniqueConstraint("component_id", "name"),
    )
    _create(
        "wires",
        "single wires and cores of cables, each between two terminals",
        _of("products", "product_id", "that it is part of"),
        _text("name", "number or designation, unique in the product"),
        _of("terminals", "a_terminal_id", "that its end a is placed in"),
        _of("terminals", "b_terminal_id", "that its end b is placed in"),
        _text("colour", "IEC 60757 code; of several colours one after another; empty of a shield"),
        sa.Column("section_mm2", sa.Float, nullable=False, comment="[mm^2] of the conductor"),
        _number("length_m", "[m] from tip to tip; null if it is not known"),
        _of("cables", "cable_id", "that it is a core of; null of a single wire", optional=True),
        _text("core", "its name in the cable; empty of a single wire"),
        _text("source", "place in the design file"),
        sa.CheckConstraint("a_terminal_id <> b_terminal_id", name="ends"),
        sa.CheckConstraint("section_mm2 > 0", name="section"),
        sa.UniqueConstraint("a_terminal_id"),
        sa.UniqueConstraint("b_terminal_id"),
        sa.UniqueConstraint("product_id", "name"),
    )
    _create(
        "routes",
        "the segments that each wire passes, from its end a to its end b",
        _of("wires", "wire_id", "that passes", key=True),
        sa.Column(
            "position",
            sa.Integer,
            primary_key=True,
            autoincrement=False,
            comment="in the route, from 0",
        ),
        _of("segments", "segment_id", "that is passed"),
        has_id=False,
    )
    _create(
        "tasks",
        "what an order asks of the cell: one wire to be placed each",
        _of("orders", "order_id", "that it is part of"),
        _of("wires", "wire_id", "that is to be placed"),
        _text("state", "open, placed or failed, by its last execution"),
        sa.UniqueConstraint("order_id", "wire_id"),
    )
    _create(
        "executions",
        "executions of the behaviors of tasks",
        _of("runs", "run_id", "that it was part of"),
        _of("tasks", "task_id", "whose behavior was executed"),
        _text("behavior", "its name"),
        sa.Column("attempt", sa.Integer, nullable=False, comment="at the task in this run, from 1"),
        _text("outcome", "of the behavior, or how it ended without one"),
        sa.Column(
            "placed", sa.Boolean, nullable=False, comment="whether the cell found the wire placed"
        ),
        sa.Column("started_s", sa.Float, nullable=False, comment="[s] ROS time"),
        sa.Column("ended_s", sa.Float, nullable=False, comment="[s] ROS time"),
    )
    _create(
        "ability_records",
        "executions of abilities, as remodel_msgs/AbilityRecord tells them",
        _of("executions", "execution_id", "that it was part of"),
        _text("state_path", "of the state in the behavior"),
        _text("ability", "its name"),
        _text("outcome", "of the state; empty when it was left without one"),
        sa.Column(
            "error_code", sa.Integer, nullable=False, comment="remodel_msgs/ErrorCode, 0 for none"
        ),
        _text("text", "the result's message, or its error message"),
        sa.Column("ended_s", sa.Float, nullable=False, comment="[s] ROS time"),
        sa.Column("elapsed_s", sa.Float, nullable=False, comment="[s] ROS time"),
    )
