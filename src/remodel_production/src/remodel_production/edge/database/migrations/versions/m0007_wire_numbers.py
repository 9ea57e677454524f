"""Wires have the numbers of their design; components are on the plate, in the door or outside."""

from __future__ import annotations

from alembic import op
from sqlalchemy import Column, String

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Add the numbers, which are not known of the products before, and rename the field."""
    op.execute("UPDATE components SET mount = 'outside' WHERE mount = 'field'")
    op.add_column(
        "wires",
        Column(
            "number",
            String,
            nullable=False,
            server_default="",
            comment="that the design gives it; several wires may have the same; empty if none",
        ),
    )
