"""Orders have rehearsals."""

from __future__ import annotations

from alembic import op
from sqlalchemy import Column, DateTime, ForeignKey, Integer

from remodel_production.edge.database.production_models import PackedJson

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Add their table."""
    op.create_table(
        "rehearsals",
        Column("id", Integer, primary_key=True, comment="number of the row"),
        Column(
            "order_id",
            Integer,
            ForeignKey("orders.id", ondelete="CASCADE"),
            nullable=False,
            index=True,
            comment="that was rehearsed",
        ),
        Column("made", DateTime, nullable=False, comment="wall time, UTC"),
        Column(
            "data",
            PackedJson,
            nullable=False,
            comment="wires, trials and calls of abilities, as remodel_run/rehearsal.py has them",
        ),
        comment="trials of orders in the simulated cell",
    )
