"""The tables of the production database, as the first release has them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = None


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "abilities",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column(
            "name", sa.String(), nullable=False, comment="of the action, such as InsertCable"
        ),
        sa.Column("description", sa.String(), nullable=False, comment="what it does, for a person"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_abilities")),
        sa.UniqueConstraint("name", name=op.f("uq_abilities_name")),
        comment="what the cell can do, by its actions",
    )
    op.create_table(
        "cells",
        sa.Column("name", sa.String(), nullable=False, comment="of the cell"),
        sa.Column(
            "token",
            sa.Integer(),
            nullable=False,
            comment="number of the ownership, which grows by 1 with each",
        ),
        sa.Column(
            "station",
            sa.String(),
            nullable=False,
            comment="that owns it, or owned it last; it may take over from itself at once",
        ),
        sa.Column(
            "holder",
            sa.String(),
            nullable=False,
            comment="the supervisor's host, process and ROS master, for persons",
        ),
        sa.Column(
            "lease_until",
            sa.Float(),
            nullable=True,
            comment=(
                "[s] since 1970 by the database's clock, until which no other station may "
                "own it; null if it has no owner"
            ),
        ),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_cells")),
        comment="which supervisor owns each cell; one at a time may act and record",
    )
    op.create_table(
        "charts",
        sa.Column("hash", sa.String(), nullable=False, comment="SHA-256 of the chart"),
        sa.Column("xml", sa.LargeBinary(), nullable=False, comment="the chart"),
        sa.PrimaryKeyConstraint("hash", name=op.f("pk_charts")),
        comment="charts of behaviors that runs have begun, each once",
    )
    op.create_table(
        "products",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column(
            "title", sa.String(), nullable=False, comment="of the design; empty if it has none"
        ),
        sa.Column("source", sa.String(), nullable=False, comment="name of the design file"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_products")),
        comment="what is built: a cabinet or a harness, as one design file describes it",
    )
    op.create_table(
        "ability_parameters",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("ability_id", sa.Integer(), nullable=False, comment="that takes it"),
        sa.Column("position", sa.Integer(), nullable=False, comment="in the goal, from 0"),
        sa.Column("name", sa.String(), nullable=False, comment="of the goal's field"),
        sa.Column(
            "type",
            sa.String(),
            nullable=False,
            comment="of the goal's field, as ROS messages name it",
        ),
        sa.Column(
            "description", sa.String(), nullable=False, comment="with unit and frame, for a person"
        ),
        sa.ForeignKeyConstraint(
            ["ability_id"],
            ["abilities.id"],
            name=op.f("fk_ability_parameters_ability_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_ability_parameters")),
        sa.UniqueConstraint(
            "ability_id", "name", name=op.f("uq_ability_parameters_ability_id_name")
        ),
        comment="the parameters of an ability's goal",
    )
    op.create_index(
        op.f("ix_ability_parameters_ability_id"), "ability_parameters", ["ability_id"], unique=False
    )
    op.create_table(
        "cables",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that it is part of"),
        sa.Column("name", sa.String(), nullable=False, comment="unique in the product"),
        sa.Column(
            "kind",
            sa.String(),
            nullable=False,
            comment="its type or article; empty if it is not known",
        ),
        sa.Column("length_m", sa.Float(), nullable=True, comment="[m]; null if it is not known"),
        sa.Column("shielded", sa.Boolean(), nullable=False, comment="whether it has a shield"),
        sa.Column("source", sa.String(), nullable=False, comment="place in the design file"),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_cables_product_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_cables")),
        sa.UniqueConstraint("product_id", "name", name=op.f("uq_cables_product_id_name")),
        comment="cables, whose cores and shields are wires",
    )
    op.create_index(op.f("ix_cables_product_id"), "cables", ["product_id"], unique=False)
    op.create_table(
        "nodes",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that the node is of"),
        sa.Column("name", sa.String(), nullable=False, comment="unique in the product"),
        sa.Column(
            "x_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "y_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "z_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_nodes_product_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_nodes")),
        sa.UniqueConstraint("product_id", "name", name=op.f("uq_nodes_product_id_name")),
        comment="where segments meet or end",
    )
    op.create_index(op.f("ix_nodes_product_id"), "nodes", ["product_id"], unique=False)
    op.create_table(
        "notes",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that was imported"),
        sa.Column(
            "text",
            sa.String(),
            nullable=False,
            comment="one line, with its place in the design file",
        ),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_notes_product_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_notes")),
        comment="what the import of a product assumed and left out",
    )
    op.create_index(op.f("ix_notes_product_id"), "notes", ["product_id"], unique=False)
    op.create_table(
        "orders",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("name", sa.String(), nullable=False, comment="by which people call the order"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that is to be built"),
        sa.Column(
            "units",
            sa.Integer(),
            nullable=False,
            comment="how many products of it were begun so far",
        ),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_orders_product_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_orders")),
        sa.UniqueConstraint("name", name=op.f("uq_orders_name")),
        comment="what is to be built now",
    )
    op.create_index(op.f("ix_orders_product_id"), "orders", ["product_id"], unique=False)
    op.create_table(
        "components",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that it is part of"),
        sa.Column(
            "name", sa.String(), nullable=False, comment="designation, unique in the product"
        ),
        sa.Column("kind", sa.String(), nullable=False, comment="what it is, for a person"),
        sa.Column("role", sa.String(), nullable=False, comment="device or connector"),
        sa.Column(
            "part_number",
            sa.String(),
            nullable=False,
            comment="of its article; empty if it is not known",
        ),
        sa.Column(
            "mount",
            sa.String(),
            nullable=False,
            comment="plate (in the cabinet, or on the board) or field (outside)",
        ),
        sa.Column(
            "node_id",
            sa.Integer(),
            nullable=True,
            comment="of the routes at which it sits; null if at none",
        ),
        sa.Column(
            "x_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "y_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "z_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "qx",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the product's; null if it is not known",
        ),
        sa.Column(
            "qy",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the product's; null if it is not known",
        ),
        sa.Column(
            "qz",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the product's; null if it is not known",
        ),
        sa.Column(
            "qw",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the product's; null if it is not known",
        ),
        sa.ForeignKeyConstraint(
            ["node_id"], ["nodes.id"], name=op.f("fk_components_node_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["product_id"],
            ["products.id"],
            name=op.f("fk_components_product_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_components")),
        sa.UniqueConstraint("product_id", "name", name=op.f("uq_components_product_id_name")),
        comment="devices with clamps and connectors with cavities",
    )
    op.create_index(op.f("ix_components_node_id"), "components", ["node_id"], unique=False)
    op.create_index(op.f("ix_components_product_id"), "components", ["product_id"], unique=False)
    op.create_table(
        "constraints",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("order_id", sa.Integer(), nullable=False, comment="whose plan it is about"),
        sa.Column(
            "section", sa.String(), nullable=False, comment="of the preferences' document: require"
        ),
        sa.Column("position", sa.Integer(), nullable=False, comment="in its section, from 0"),
        sa.Column(
            "name",
            sa.String(),
            nullable=False,
            comment="the user's name for it; empty if it has none",
        ),
        sa.Column("rule", sa.JSON(), nullable=False, comment="the entry, as in the document"),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_constraints_order_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_constraints")),
        sa.UniqueConstraint(
            "order_id", "section", "position", name=op.f("uq_constraints_order_id_section_position")
        ),
        comment="what the user requires of an order's plan; no plan breaks it",
    )
    op.create_index(op.f("ix_constraints_order_id"), "constraints", ["order_id"], unique=False)
    op.create_table(
        "preferences",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("order_id", sa.Integer(), nullable=False, comment="whose plan it is about"),
        sa.Column(
            "section",
            sa.String(),
            nullable=False,
            comment="of the preferences' document: prefer, or weights",
        ),
        sa.Column("position", sa.Integer(), nullable=False, comment="in its section, from 0"),
        sa.Column(
            "name",
            sa.String(),
            nullable=False,
            comment="the user's name for it; empty if it has none",
        ),
        sa.Column("rule", sa.JSON(), nullable=False, comment="the entry, as in the document"),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_preferences_order_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_preferences")),
        sa.UniqueConstraint(
            "order_id", "section", "position", name=op.f("uq_preferences_order_id_section_position")
        ),
        comment="what the user prefers of an order's plan; a plan may break it, and pays",
    )
    op.create_index(op.f("ix_preferences_order_id"), "preferences", ["order_id"], unique=False)
    op.create_table(
        "runs",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("order_id", sa.Integer(), nullable=False, comment="that was run"),
        sa.Column("started", sa.DateTime(), nullable=False, comment="wall time, UTC"),
        sa.Column("cell", sa.String(), nullable=False, comment="name of the cell that does it"),
        sa.Column("ended", sa.Boolean(), nullable=False, comment="or not"),
        sa.Column(
            "owner", sa.Integer(), nullable=False, comment="token of the cell's owner that does it"
        ),
        sa.Column("events", sa.Integer(), nullable=False, comment="how many it has so far"),
        sa.Column(
            "serial",
            sa.String(),
            nullable=False,
            comment="serial number of the product; empty if not known",
        ),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_runs_order_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_runs")),
        comment="attempts to build an order, or part of it",
    )
    op.create_index(op.f("ix_runs_order_id"), "runs", ["order_id"], unique=False)
    op.create_index(op.f("ix_runs_serial"), "runs", ["serial"], unique=False)
    op.create_table(
        "segments",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that the segment is of"),
        sa.Column("name", sa.String(), nullable=False, comment="unique in the product"),
        sa.Column(
            "kind", sa.String(), nullable=False, comment="duct (of a cabinet) or bundle (of wires)"
        ),
        sa.Column("start_node_id", sa.Integer(), nullable=False, comment="where it starts"),
        sa.Column("end_node_id", sa.Integer(), nullable=False, comment="where it ends"),
        sa.Column("length_m", sa.Float(), nullable=False, comment="[m] along its course"),
        sa.CheckConstraint("length_m >= 0", name=op.f("ck_segments_length")),
        sa.ForeignKeyConstraint(
            ["end_node_id"], ["nodes.id"], name=op.f("fk_segments_end_node_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_segments_product_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["start_node_id"],
            ["nodes.id"],
            name=op.f("fk_segments_start_node_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_segments")),
        sa.UniqueConstraint("product_id", "name", name=op.f("uq_segments_product_id_name")),
        comment="pieces of the routes of wires, between two nodes",
    )
    op.create_index(op.f("ix_segments_end_node_id"), "segments", ["end_node_id"], unique=False)
    op.create_index(op.f("ix_segments_product_id"), "segments", ["product_id"], unique=False)
    op.create_index(op.f("ix_segments_start_node_id"), "segments", ["start_node_id"], unique=False)
    op.create_table(
        "clips",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that the clip is of"),
        sa.Column("name", sa.String(), nullable=False, comment="unique in the product"),
        sa.Column(
            "kind",
            sa.String(),
            nullable=False,
            comment="its type, for a person; empty if it is not known",
        ),
        sa.Column(
            "segment_id", sa.Integer(), nullable=True, comment="that it sits on; null if at a node"
        ),
        sa.Column(
            "along", sa.Float(), nullable=False, comment="place on the segment, 0 at its start to 1"
        ),
        sa.Column(
            "node_id", sa.Integer(), nullable=True, comment="that it sits at; null if on a segment"
        ),
        sa.Column(
            "x_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "y_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.Column(
            "z_m",
            sa.Float(),
            nullable=True,
            comment="[m] place in the product's frame; null if it is not known",
        ),
        sa.CheckConstraint(
            "(segment_id IS NULL) <> (node_id IS NULL)", name=op.f("ck_clips_place")
        ),
        sa.CheckConstraint("along >= 0 AND along <= 1", name=op.f("ck_clips_along")),
        sa.ForeignKeyConstraint(
            ["node_id"], ["nodes.id"], name=op.f("fk_clips_node_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_clips_product_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["segment_id"], ["segments.id"], name=op.f("fk_clips_segment_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_clips")),
        sa.UniqueConstraint("product_id", "name", name=op.f("uq_clips_product_id_name")),
        comment="what holds the wires that pass it, on a segment or at a node",
    )
    op.create_index(op.f("ix_clips_node_id"), "clips", ["node_id"], unique=False)
    op.create_index(op.f("ix_clips_product_id"), "clips", ["product_id"], unique=False)
    op.create_index(op.f("ix_clips_segment_id"), "clips", ["segment_id"], unique=False)
    op.create_table(
        "run_events",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("run_id", sa.Integer(), nullable=False, comment="in which it happened"),
        sa.Column("position", sa.Integer(), nullable=False, comment="in the run, from 0"),
        sa.Column("at", sa.DateTime(), nullable=False, comment="wall time, UTC"),
        sa.Column("kind", sa.String(), nullable=False, comment="of the event, such as TaskBegun"),
        sa.Column(
            "data",
            sa.LargeBinary(),
            nullable=False,
            comment="its fields, by name; a chart by its hash (chart_hash)",
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name=op.f("fk_run_events_run_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_run_events")),
        sa.UniqueConstraint("run_id", "position", name=op.f("uq_run_events_run_id_position")),
        comment="what happened in runs; rows are added, and never changed",
    )
    op.create_table(
        "run_snapshots",
        sa.Column("run_id", sa.Integer(), nullable=False, comment="whose state it is"),
        sa.Column("events", sa.Integer(), nullable=False, comment="how many events it covers"),
        sa.Column(
            "data",
            sa.LargeBinary(),
            nullable=False,
            comment="the state, with the version of its form",
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name=op.f("fk_run_snapshots_run_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("run_id", name=op.f("pk_run_snapshots")),
        comment="the state of each run after some of its events, to resume it sooner",
    )
    op.create_table(
        "terminals",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("component_id", sa.Integer(), nullable=False, comment="that it is part of"),
        sa.Column("name", sa.String(), nullable=False, comment="unique in the component"),
        sa.Column(
            "side", sa.String(), nullable=False, comment="top or bottom, on which it opens as drawn"
        ),
        sa.Column(
            "point",
            sa.String(),
            nullable=False,
            comment="of the drawing that it shares with other terminals; empty if with none",
        ),
        sa.Column(
            "kind",
            sa.String(),
            nullable=False,
            comment="its type, such as the article of the contact; empty if it is not known",
        ),
        sa.Column(
            "x_m",
            sa.Float(),
            nullable=True,
            comment="[m] place of its opening in the component's frame; null if it is not known",
        ),
        sa.Column(
            "y_m",
            sa.Float(),
            nullable=True,
            comment="[m] place of its opening in the component's frame; null if it is not known",
        ),
        sa.Column(
            "z_m",
            sa.Float(),
            nullable=True,
            comment="[m] place of its opening in the component's frame; null if it is not known",
        ),
        sa.Column(
            "qx",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the component's; null if it is not known",
        ),
        sa.Column(
            "qy",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the component's; null if it is not known",
        ),
        sa.Column(
            "qz",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the component's; null if it is not known",
        ),
        sa.Column(
            "qw",
            sa.Float(),
            nullable=True,
            comment="unit quaternion of its frame in the component's; null if it is not known",
        ),
        sa.Column(
            "approach_x",
            sa.Float(),
            nullable=True,
            comment=(
                "unit vector by which an end goes in, component's frame; null if it is not known"
            ),
        ),
        sa.Column(
            "approach_y",
            sa.Float(),
            nullable=True,
            comment=(
                "unit vector by which an end goes in, component's frame; null if it is not known"
            ),
        ),
        sa.Column(
            "approach_z",
            sa.Float(),
            nullable=True,
            comment=(
                "unit vector by which an end goes in, component's frame; null if it is not known"
            ),
        ),
        sa.Column(
            "clearance_m",
            sa.Float(),
            nullable=True,
            comment="[m] that a gripper needs around the opening; null if it is not known",
        ),
        sa.Column(
            "insertion_force_limit_n",
            sa.Float(),
            nullable=True,
            comment="[N] that an insertion must not exceed; null if it is not known",
        ),
        sa.CheckConstraint("clearance_m >= 0", name=op.f("ck_terminals_clearance")),
        sa.CheckConstraint(
            "insertion_force_limit_n > 0", name=op.f("ck_terminals_insertion_force_limit")
        ),
        sa.ForeignKeyConstraint(
            ["component_id"],
            ["components.id"],
            name=op.f("fk_terminals_component_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_terminals")),
        sa.UniqueConstraint("component_id", "name", name=op.f("uq_terminals_component_id_name")),
        comment="clamps of devices and cavities of connectors, each for one wire end",
    )
    op.create_index(op.f("ix_terminals_component_id"), "terminals", ["component_id"], unique=False)
    op.create_table(
        "wires",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("product_id", sa.Integer(), nullable=False, comment="that it is part of"),
        sa.Column(
            "name",
            sa.String(),
            nullable=False,
            comment="number or designation, unique in the product",
        ),
        sa.Column(
            "a_terminal_id", sa.Integer(), nullable=False, comment="that its end a is placed in"
        ),
        sa.Column(
            "b_terminal_id", sa.Integer(), nullable=False, comment="that its end b is placed in"
        ),
        sa.Column(
            "colour",
            sa.String(),
            nullable=False,
            comment="IEC 60757 code; of several colours one after another; empty of a shield",
        ),
        sa.Column("section_mm2", sa.Float(), nullable=False, comment="[mm^2] of the conductor"),
        sa.Column(
            "length_m",
            sa.Float(),
            nullable=True,
            comment="[m] from tip to tip; null if it is not known",
        ),
        sa.Column(
            "cable_id",
            sa.Integer(),
            nullable=True,
            comment="that it is a core of; null of a single wire",
        ),
        sa.Column(
            "core",
            sa.String(),
            nullable=False,
            comment="its name in the cable; empty of a single wire",
        ),
        sa.Column("source", sa.String(), nullable=False, comment="place in the design file"),
        sa.CheckConstraint("a_terminal_id <> b_terminal_id", name=op.f("ck_wires_ends")),
        sa.CheckConstraint("section_mm2 > 0", name=op.f("ck_wires_section")),
        sa.ForeignKeyConstraint(
            ["a_terminal_id"],
            ["terminals.id"],
            name=op.f("fk_wires_a_terminal_id"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["b_terminal_id"],
            ["terminals.id"],
            name=op.f("fk_wires_b_terminal_id"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["cable_id"], ["cables.id"], name=op.f("fk_wires_cable_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["product_id"], ["products.id"], name=op.f("fk_wires_product_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_wires")),
        sa.UniqueConstraint("a_terminal_id", name=op.f("uq_wires_a_terminal_id")),
        sa.UniqueConstraint("b_terminal_id", name=op.f("uq_wires_b_terminal_id")),
        sa.UniqueConstraint("product_id", "name", name=op.f("uq_wires_product_id_name")),
        comment="single wires and cores of cables, each between two terminals",
    )
    op.create_index(op.f("ix_wires_a_terminal_id"), "wires", ["a_terminal_id"], unique=False)
    op.create_index(op.f("ix_wires_b_terminal_id"), "wires", ["b_terminal_id"], unique=False)
    op.create_index(op.f("ix_wires_cable_id"), "wires", ["cable_id"], unique=False)
    op.create_index(op.f("ix_wires_product_id"), "wires", ["product_id"], unique=False)
    op.create_table(
        "routes",
        sa.Column("wire_id", sa.Integer(), nullable=False, comment="that passes"),
        sa.Column(
            "position",
            sa.Integer(),
            autoincrement=False,
            nullable=False,
            comment="in the route, from 0",
        ),
        sa.Column("segment_id", sa.Integer(), nullable=False, comment="that is passed"),
        sa.ForeignKeyConstraint(
            ["segment_id"], ["segments.id"], name=op.f("fk_routes_segment_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["wire_id"], ["wires.id"], name=op.f("fk_routes_wire_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("wire_id", "position", name=op.f("pk_routes")),
        comment="the segments that each wire passes, from its end a to its end b",
    )
    op.create_index(op.f("ix_routes_segment_id"), "routes", ["segment_id"], unique=False)
    op.create_table(
        "tasks",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("order_id", sa.Integer(), nullable=False, comment="that it is part of"),
        sa.Column("wire_id", sa.Integer(), nullable=False, comment="that is to be placed"),
        sa.Column("state", sa.String(), nullable=False, comment="open, begun, done or `set aside`"),
        sa.Column(
            "cell",
            sa.String(),
            nullable=False,
            comment="name of the cell that has begun it; empty if none has",
        ),
        sa.Column(
            "lease_until",
            sa.Float(),
            nullable=True,
            comment=(
                "[s] since 1970 by the database's clock, until which the cell has it for "
                "itself; null if it is not known"
            ),
        ),
        sa.Column(
            "token",
            sa.Integer(),
            nullable=False,
            comment="of the cell's owner that has begun it; or 0",
        ),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_tasks_order_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["wire_id"], ["wires.id"], name=op.f("fk_tasks_wire_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_tasks")),
        sa.UniqueConstraint("order_id", "wire_id", name=op.f("uq_tasks_order_id_wire_id")),
        comment="what an order asks of the cell: one wire to be placed each",
    )
    op.create_index(op.f("ix_tasks_order_id"), "tasks", ["order_id"], unique=False)
    op.create_index(op.f("ix_tasks_wire_id"), "tasks", ["wire_id"], unique=False)
    op.create_table(
        "executions",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("run_id", sa.Integer(), nullable=False, comment="that it was part of"),
        sa.Column("task_id", sa.Integer(), nullable=False, comment="whose behavior was executed"),
        sa.Column("behavior", sa.String(), nullable=False, comment="its name"),
        sa.Column(
            "attempt", sa.Integer(), nullable=False, comment="at the task in this run, from 1"
        ),
        sa.Column(
            "outcome",
            sa.String(),
            nullable=False,
            comment="of the behavior, or how it ended without one",
        ),
        sa.Column(
            "placed", sa.Boolean(), nullable=False, comment="whether the cell found the wire placed"
        ),
        sa.Column("started_s", sa.Float(), nullable=False, comment="[s] ROS time"),
        sa.Column("ended_s", sa.Float(), nullable=False, comment="[s] ROS time"),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name=op.f("fk_executions_run_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["task_id"], ["tasks.id"], name=op.f("fk_executions_task_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_executions")),
        comment="executions of the behaviors of tasks",
    )
    op.create_index(op.f("ix_executions_run_id"), "executions", ["run_id"], unique=False)
    op.create_index(op.f("ix_executions_task_id"), "executions", ["task_id"], unique=False)
    op.create_table(
        "ability_records",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("execution_id", sa.Integer(), nullable=False, comment="that it was part of"),
        sa.Column(
            "state_path", sa.String(), nullable=False, comment="of the state in the behavior"
        ),
        sa.Column("ability", sa.String(), nullable=False, comment="its name"),
        sa.Column(
            "outcome",
            sa.String(),
            nullable=False,
            comment="of the state; empty when it was left without one",
        ),
        sa.Column(
            "error_code", sa.Integer(), nullable=False, comment="remodel_msgs/ErrorCode, 0 for none"
        ),
        sa.Column("ended_s", sa.Float(), nullable=False, comment="[s] ROS time"),
        sa.Column("elapsed_s", sa.Float(), nullable=False, comment="[s] ROS time"),
        sa.Column(
            "position",
            sa.Integer(),
            nullable=True,
            comment=("of its event in the run, which has the rest; null in runs of older programs"),
        ),
        sa.Column(
            "data",
            sa.LargeBinary(),
            nullable=True,
            comment="text, goal_id, parameters and measurements; null if an event has them",
        ),
        sa.ForeignKeyConstraint(
            ["execution_id"],
            ["executions.id"],
            name=op.f("fk_ability_records_execution_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_ability_records")),
        comment="executions of abilities, as remodel_msgs/AbilityRecord reports them",
    )
    op.create_index(
        op.f("ix_ability_records_execution_id"), "ability_records", ["execution_id"], unique=False
    )
    op.create_table(
        "decisions",
        sa.Column("id", sa.Integer(), nullable=False, comment="number of the row"),
        sa.Column("execution_id", sa.Integer(), nullable=False, comment="that failed"),
        sa.Column(
            "fault",
            sa.String(),
            nullable=False,
            comment="kind of fault, as in remodel_msgs/config/faults.yaml",
        ),
        sa.Column(
            "error_code",
            sa.Integer(),
            nullable=False,
            comment="remodel_msgs/ErrorCode that decided it",
        ),
        sa.Column(
            "evidence", sa.String(), nullable=False, comment="what the ability, or the engine, said"
        ),
        sa.Column(
            "response",
            sa.String(),
            nullable=False,
            comment="what was done, as in remodel_msgs/config/faults.yaml",
        ),
        sa.Column("because", sa.String(), nullable=False, comment="the reason, a sentence"),
        sa.ForeignKeyConstraint(
            ["execution_id"],
            ["executions.id"],
            name=op.f("fk_decisions_execution_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_decisions")),
        comment="what was done about executions that failed, and why",
    )
    op.create_index(op.f("ix_decisions_execution_id"), "decisions", ["execution_id"], unique=False)
