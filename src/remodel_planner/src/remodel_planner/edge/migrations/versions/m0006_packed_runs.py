"""Events and records compressed, charts once by their hashes, and snapshots of states."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Any

import sqlalchemy as sa
from alembic import op

from remodel_planner.edge.packed import packed, packed_json

revision = "0006"
down_revision = "0005"

# How many rows are converted at once.
_BATCH = 1000
_MOVED = ("text", "goal_id", "parameters", "measurements")
_Row = dict[str, Any]


def upgrade() -> None:
    """Make the tables, and convert the rows; nothing is lost."""
    op.create_table(
        "charts",
        sa.Column("hash", sa.String, primary_key=True, comment="SHA-256 of the chart"),
        sa.Column("xml", sa.LargeBinary, nullable=False, comment="the chart"),
        comment="charts of behaviors that runs have begun, each once",
    )
    op.create_table(
        "run_snapshots",
        sa.Column(
            "run_id",
            sa.Integer,
            sa.ForeignKey("runs.id", ondelete="CASCADE"),
            primary_key=True,
            comment="whose state it is",
        ),
        sa.Column("events", sa.Integer, nullable=False, comment="how many events it covers"),
        sa.Column(
            "data",
            sa.LargeBinary,
            nullable=False,
            comment="the state, with the version of its form",
        ),
        comment="the state of each run after some of its events, to resume it sooner",
    )
    _pack_events()
    _pack_records()


def _pack_events() -> None:
    comment = "its fields, by name; a chart by its hash (chart_hash)"
    op.add_column(
        "run_events",
        sa.Column("packed", sa.LargeBinary, nullable=False, server_default="", comment=comment),
    )
    _convert("run_events", "packed", _packed_event)
    op.drop_column("run_events", "data")
    op.alter_column("run_events", "packed", new_column_name="data")
    # (run_id, position) has an index, too.
    op.drop_index("ix_run_events_run_id", "run_events")


def _packed_event(row: _Row) -> bytes:
    data = row["data"] if isinstance(row["data"], dict) else json.loads(row["data"])
    if "chart" in data:
        xml = data.pop("chart")
        data["chart_hash"] = hashlib.sha256(xml.encode()).hexdigest()
        op.get_bind().execute(
            sa.text(
                "INSERT INTO charts (hash, xml) VALUES (:hash, :xml) ON CONFLICT (hash) DO NOTHING"
            ),
            {"hash": data["chart_hash"], "xml": packed(xml)},
        )
    return packed_json(data)


def _pack_records() -> None:
    op.add_column(
        "ability_records",
        sa.Column(
            "position",
            sa.Integer,
            nullable=True,
            comment="of its event in the run, which has the rest; null in runs of older programs",
        ),
    )
    op.add_column(
        "ability_records",
        sa.Column(
            "data",
            sa.LargeBinary,
            nullable=True,
            comment="text, goal_id, parameters and measurements; null if an event has them",
        ),
    )
    _convert("ability_records", "data", lambda row: packed_json({n: row[n] for n in _MOVED}))
    for name in _MOVED:
        op.drop_column("ability_records", name)


def _convert(table: str, column: str, value: Callable[[_Row], bytes]) -> None:
    """Set a column of all rows by what a function returns for each."""
    connection = op.get_bind()
    rows = sa.Table(table, sa.MetaData(), autoload_with=connection)
    read = [each for each in rows.c if each.name != column]
    last = 0
    while True:
        asked = sa.select(*read).where(rows.c.id > last).order_by(rows.c.id).limit(_BATCH)
        batch = [dict(row) for row in connection.execute(asked).mappings()]
        if not batch:
            return
        last = batch[-1]["id"]
        connection.execute(
            rows.update()
            .where(rows.c.id == sa.bindparam("number"))
            .values({column: sa.bindparam("value")}),
            [{"number": row["id"], "value": value(row)} for row in batch],
        )
