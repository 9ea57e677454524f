"""Orders with components, terminals and wires; runs with executions and records."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the tables that databases had before they were versioned."""
    op.create_table(
        "orders",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("name", sa.String, nullable=False, unique=True),
        sa.Column("title", sa.String, nullable=False),
        sa.Column("source", sa.String, nullable=False),
    )
    op.create_table(
        "components",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("order_id", sa.Integer, sa.ForeignKey("orders.id"), nullable=False),
        sa.Column("name", sa.String, nullable=False),
        sa.Column("kind", sa.String, nullable=False),
        sa.UniqueConstraint("order_id", "name"),
    )
    op.create_table(
        "terminals",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("component_id", sa.Integer, sa.ForeignKey("components.id"), nullable=False),
        sa.Column("name", sa.String, nullable=False),
        sa.Column("side", sa.String, nullable=False),
        sa.Column("point", sa.String, nullable=False),
        sa.UniqueConstraint("component_id", "name"),
    )
    op.create_table(
        "wires",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("order_id", sa.Integer, sa.ForeignKey("orders.id"), nullable=False),
        sa.Column("name", sa.String, nullable=False),
        sa.Column(
            "a_terminal_id", sa.Integer, sa.ForeignKey("terminals.id"), nullable=False, unique=True
        ),
        sa.Column(
            "b_terminal_id", sa.Integer, sa.ForeignKey("terminals.id"), nullable=False, unique=True
        ),
        sa.Column("colour", sa.String, nullable=False),
        sa.Column("section_mm2", sa.Float, nullable=False),
        sa.Column("source", sa.String, nullable=False),
        sa.UniqueConstraint("order_id", "name"),
    )
    op.create_table(
        "notes",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("order_id", sa.Integer, sa.ForeignKey("orders.id"), nullable=False),
        sa.Column("text", sa.String, nullable=False),
    )
    op.create_table(
        "runs",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("order_id", sa.Integer, sa.ForeignKey("orders.id"), nullable=False),
        sa.Column("started", sa.DateTime, nullable=False),
    )
    op.create_table(
        "executions",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("run_id", sa.Integer, sa.ForeignKey("runs.id"), nullable=False),
        sa.Column("wire_id", sa.Integer, sa.ForeignKey("wires.id"), nullable=False),
        sa.Column("behavior", sa.String, nullable=False),
        sa.Column("attempt", sa.Integer, nullable=False),
        sa.Column("outcome", sa.String, nullable=False),
        sa.Column("placed", sa.Boolean, nullable=False),
        sa.Column("started_s", sa.Float, nullable=False),
        sa.Column("ended_s", sa.Float, nullable=False),
    )
    op.create_table(
        "ability_records",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("execution_id", sa.Integer, sa.ForeignKey("executions.id"), nullable=False),
        sa.Column("state_path", sa.String, nullable=False),
        sa.Column("ability", sa.String, nullable=False),
        sa.Column("outcome", sa.String, nullable=False),
        sa.Column("error_code", sa.Integer, nullable=False),
        sa.Column("text", sa.String, nullable=False),
        sa.Column("ended_s", sa.Float, nullable=False),
        sa.Column("elapsed_s", sa.Float, nullable=False),
    )
