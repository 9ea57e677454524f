"""Who owns each cell, and the serial numbers of products."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Make the table and the columns; of earlier runs no owner and no serial number is known."""
    op.create_table(
        "cells",
        sa.Column("name", sa.String, primary_key=True, comment="of the cell"),
        sa.Column(
            "token",
            sa.Integer,
            nullable=False,
            comment="number of the ownership, which grows by 1 with each",
        ),
        sa.Column(
            "station",
            sa.String,
            nullable=False,
            comment="that owns it, or owned it last; it may take over from itself at once",
        ),
        sa.Column(
            "holder",
            sa.String,
            nullable=False,
            comment="the supervisor's host, process and ROS master, for persons",
        ),
        sa.Column(
            "lease_until",
            sa.Float,
            nullable=True,
            comment="[s] since 1970 by the database's clock, until which no other station may own "
            "it; null if nobody owns it",
        ),
        comment="which supervisor owns each cell; one at a time may act and record",
    )
    for table, name, comment in (
        ("orders", "units", "how many products of it were begun so far"),
        ("tasks", "token", "of the cell's owner that has begun it; or 0"),
        ("runs", "owner", "token of the cell's owner that does it"),
        ("runs", "events", "how many it has so far"),
    ):
        op.add_column(
            table,
            sa.Column(name, sa.Integer, nullable=False, server_default="0", comment=comment),
        )
    op.add_column(
        "runs",
        sa.Column(
            "serial",
            sa.String,
            nullable=False,
            server_default="",
            comment="serial number of the product; empty if not known",
        ),
    )
    op.create_index("ix_runs_serial", "runs", ["serial"])
    op.execute("UPDATE runs SET events = (SELECT count(*) FROM run_events WHERE run_id = runs.id)")
