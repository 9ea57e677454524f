"""What was done about failures, and why."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Make the table; earlier runs recorded no decisions."""
    op.create_table(
        "decisions",
        sa.Column("id", sa.Integer, primary_key=True, comment="number of the row"),
        sa.Column(
            "execution_id",
            sa.Integer,
            sa.ForeignKey("executions.id", ondelete="CASCADE"),
            nullable=False,
            index=True,
            comment="that failed",
        ),
        _text("fault", "kind of fault, as in remodel_msgs/config/faults.yaml"),
        sa.Column(
            "error_code",
            sa.Integer,
            nullable=False,
            comment="remodel_msgs/ErrorCode that decided it",
        ),
        _text("evidence", "what the ability, or the engine, said"),
        _text("response", "what was done, as in remodel_msgs/config/faults.yaml"),
        _text("because", "the reason, a sentence"),
        comment="what was done about executions that failed, and why",
    )


def _text(name: str, comment: str) -> sa.Column:
    return sa.Column(name, sa.String, nullable=False, comment=comment)
