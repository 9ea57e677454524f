"""Runs as rows of events, leases on tasks, and what operations were asked and have measured."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Make the table and the columns; earlier runs have no events, and count as ended."""
    op.create_table(
        "run_events",
        sa.Column("id", sa.Integer, primary_key=True, comment="number of the row"),
        sa.Column(
            "run_id",
            sa.Integer,
            sa.ForeignKey("runs.id", ondelete="CASCADE"),
            nullable=False,
            index=True,
            comment="in which it happened",
        ),
        sa.Column("position", sa.Integer, nullable=False, comment="in the run, from 0"),
        sa.Column("at", sa.DateTime, nullable=False, comment="wall time, UTC"),
        sa.Column("kind", sa.String, nullable=False, comment="of the event, such as TaskBegun"),
        sa.Column("data", sa.JSON, nullable=False, comment="its fields, by name"),
        sa.UniqueConstraint("run_id", "position"),
        comment="what happened in runs; rows are added, and never changed",
    )
    for table, column in (
        ("runs", _text("cell", "name of the cell that does it")),
        ("tasks", _text("cell", "name of the cell that has begun it; empty if none has")),
        ("ability_records", _text("goal_id", "of its goal")),
        ("ability_records", _pairs("parameters", "of its goal: name and value")),
        ("ability_records", _pairs("measurements", "of its result: name and value")),
    ):
        op.add_column(table, column)
    if op.get_context().dialect.name == "postgresql":  # SQLite keeps no comments
        op.alter_column("tasks", "state", comment="open, begun, done or set aside")
    op.execute("UPDATE tasks SET state = 'done' WHERE state = 'placed'")
    op.execute("UPDATE tasks SET state = 'set aside' WHERE state = 'failed'")
    op.add_column(
        "runs",
        sa.Column("ended", sa.Boolean, nullable=False, server_default=sa.true(), comment="or not"),
    )
    op.add_column(
        "tasks",
        sa.Column(
            "lease_until",
            sa.Float,
            nullable=True,
            comment="[s] since 1970 by the database's clock, until which the cell has it for "
            "itself; null if it is not known",
        ),
    )


def _text(name: str, comment: str) -> sa.Column:
    return sa.Column(name, sa.String, nullable=False, server_default="", comment=comment)


def _pairs(name: str, comment: str) -> sa.Column:
    return sa.Column(name, sa.JSON, nullable=False, server_default="[]", comment=comment)
