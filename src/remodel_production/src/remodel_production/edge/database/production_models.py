"""The tables of the production knowledge database; docs/production-database.md draws them.

An entry of a packed column starts with the number of its packing. Number 1 is raw deflate with the
dictionary below, which must never change: another one needs another number.

New databases are created from the models. Every table and column has a comment, which PostgreSQL
keeps. A change here needs a migration in edge/database/migrations/versions, and
`tools/draw_database.py`.
"""

from __future__ import annotations

import json
import zlib

from sqlalchemy import (
    JSON,
    Boolean,
    CheckConstraint,
    Column,
    DateTime,
    Float,
    ForeignKey,
    Integer,
    LargeBinary,
    MetaData,
    String,
    UniqueConstraint,
)
from sqlalchemy.orm import declarative_base
from sqlalchemy.types import TypeDecorator

_PACKING = b"\x01"
_RAW = -15
_ENCODER = json.JSONEncoder(separators=(",", ":"), ensure_ascii=False)

# What entries have in common; the most frequent comes last, where it costs least.
_DICTIONARY = (
    b'{"form":"1-","state":{"order":"","use_case":"","cell":"","waiting":["W1","W2","W3"]},"task'
    b's":[{"name":"W1","stage":"done","behavior":"Place Wire W1","attempts":1,"connected":["a","'
    b'b"],"outcome":"finished","began_s":1000.0,"cell_s":60.0},{"task":"W1","fault":"insertion_j'
    b'ammed","code":301,"ability":"InsertCable","state_path":"/Connect a/InsertCable","text":"",'
    b'"do":"retry_with","change":[["force_limit",10.0]],"because":"","by":"policy","at_s":1000.0'
    b'}{"task":"W1","attempt":1,"part":"whole","behavior":"Place Wire W1","at_s":1000.0,"chosen"'
    b':[],"chart_hash":"{"task":"W1","outcome":"finished","at_s":1000.0,"placed":true,"path":["/'
    b'Detect","/Connect a/LocateGearboxComponent","/Connect a/PickCable","/Connect a/InsertCable'
    b'","/Connect a/FixCable","/Pick b","/Route b","/Connect b/LocateGearboxComponent","/Connect'
    b' b/InsertCable","/Connect b/FixCable"],"pictures":["W1-1-whole-overhead-.jpg"],"denied":fa'
    b'lse}{"task":"W1","operation":{"state_path":"/Connect b/FixCable","ability":"FixCable","out'
    b'come":"fixed","error_code":0,"text":"the end withstood the pull","ended_s":1000.0,"elapsed'
    b'_s":2.0,"goal_id":"17:","parameters":[["robot_name","robot_1"],["cable_id","W1"],["compone'
    b'nt_id","Q1"],["terminal_id","B1"],["pull_test_force","10.0"],["timeout","30.0"]],"measurem'
    b'ents":[["slip","0.000"]]}}"ability":"DetectCable","outcome":"detected","view","0"],["grasp'
    b'_pose","world 0.4 -0.1 0.05 0 0 0 1"],["grip_width","0.002"]]}}"ability":"RouteWire","outc'
    b'ome":"routed","reached","2"]]}}"ability":"LocateGearboxComponent","outcome":"located","par'
    b'ameters":[["component_id","Q1"],["terminal_id","B1"],["view","0"],["timeout","30.0"]],"mea'
    b'surements":[["component_pose","world 0.4 0.1 0.05 0 0 0.7071 0.7071"],["socket_pose","worl'
    b'd 0.4 0.1 0.05 0 0 0.7071 0.7071"],["residual","0.0004"]]}}{"task":"W1","operation":{"stat'
    b'e_path":"/Connect a/InsertCable","ability":"InsertCable","outcome":"inserted","error_code"'
    b':0,"text":"","ended_s":1000.0,"elapsed_s":4.0,"goal_id":"17:","parameters":[["robot_name",'
    b'"robot_1"],["cable_id","W1"],["cable_end","a"],["component_id","Q1"],["terminal_id","T1"],'
    b'["socket_pose","panel 0.1 0.1 0.05 0 0 0.7071 0.7071"],["force_limit","8.0"],["timeout","3'
    b'0.0"]],"measurements":[["depth","0.009"],["peak_force","6.5"]]}}'
)


def packed(text: str) -> bytes:
    """Return a text compressed."""
    deflate = zlib.compressobj(6, zlib.DEFLATED, _RAW, zdict=_DICTIONARY)
    return _PACKING + deflate.compress(text.encode()) + deflate.flush()


def unpacked(data: bytes) -> str:
    """Return the text that was compressed.

    Raises:
        zlib.error: if the data are damaged, or have an unknown packing.
    """
    if data[:1] != _PACKING:
        raise zlib.error(f"unknown packing {data[:1]!r}")
    inflate = zlib.decompressobj(_RAW, zdict=_DICTIONARY)
    text = inflate.decompress(data[1:]) + inflate.flush()
    if not inflate.eof:
        raise zlib.error("the entry is cut short")
    return text.decode()


def packed_json(value: object) -> bytes:
    """Return plain data compressed."""
    return packed(_ENCODER.encode(value))


class PackedText(TypeDecorator):
    """A text, compressed."""

    impl = LargeBinary
    cache_ok = True

    def process_bind_param(self, value: str | None, _: object) -> bytes | None:
        """Compress what is stored."""
        return None if value is None else packed(value)

    def process_result_value(self, value: bytes | None, _: object) -> str | None:
        """Expand what is read."""
        return None if value is None else unpacked(bytes(value))


class PackedJson(TypeDecorator):
    """Plain data, as compressed JSON."""

    impl = LargeBinary
    cache_ok = True

    def process_bind_param(self, value: object, _: object) -> bytes | None:
        """Compress what is stored."""
        return None if value is None else packed_json(value)

    def process_result_value(self, value: bytes | None, _: object) -> object:
        """Expand what is read."""
        return None if value is None else json.loads(unpacked(bytes(value)))


_NAMES = {
    "pk": "pk_%(table_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "uq": "uq_%(table_name)s_%(column_0_N_name)s",
    "ck": "ck_%(table_name)s_%(constraint_name)s",
    "ix": "ix_%(table_name)s_%(column_0_name)s",
}
Base = declarative_base(metadata=MetaData(naming_convention=_NAMES))


def _key() -> Column:
    return Column(Integer, primary_key=True, comment="number of the row")


def _of(
    column: str, comment: str, *, optional: bool = False, key: bool = False, index: bool = True
) -> Column:
    """Return a column that refers to a row of another table, and goes when that row goes."""
    return Column(
        ForeignKey(column, ondelete="CASCADE"),
        nullable=optional,
        primary_key=key,
        index=index and not key,
        comment=comment,
    )


def _text(comment: str) -> Column:
    return Column(String, nullable=False, comment=comment)


def _number(comment: str) -> Column:
    return Column(Float, nullable=True, comment=f"{comment}; null if it is not known")


def _numbers(count: int, comment: str) -> tuple[Column, ...]:
    """Return the columns of a place, a direction or an orientation."""
    return tuple(_number(comment) for _ in range(count))


def _table(comment: str, *constraints: object) -> tuple[object, ...]:
    return (*constraints, {"comment": comment})


class ProductRow(Base):
    """A design."""

    __tablename__ = "products"
    __table_args__ = _table(
        "what is built: a cabinet or a harness, as one design file describes it"
    )
    id = _key()
    title = _text("of the design; empty if it has none")
    source = _text("name of the design file")


class NoteRow(Base):
    """A line of the import's account."""

    __tablename__ = "notes"
    __table_args__ = _table("what the import of a product assumed and left out")
    id = _key()
    product_id = _of("products.id", "that was imported")
    text = _text("one line, with its place in the design file")


class NodeRow(Base):
    """A node of the routes."""

    __tablename__ = "nodes"
    __table_args__ = _table("where segments meet or end", UniqueConstraint("product_id", "name"))
    id = _key()
    product_id = _of("products.id", "that the node is of")
    name = _text("unique in the product")
    x_m, y_m, z_m = _numbers(3, "[m] place in the product's frame")


class SegmentRow(Base):
    """A segment of the routes."""

    __tablename__ = "segments"
    __table_args__ = _table(
        "pieces of the routes of wires, between two nodes",
        UniqueConstraint("product_id", "name"),
        CheckConstraint("length_m >= 0", name="length"),
    )
    id = _key()
    product_id = _of("products.id", "that the segment is of")
    name = _text("unique in the product")
    kind = _text("duct (of a cabinet) or bundle (of wires)")
    start_node_id = _of("nodes.id", "where it starts")
    end_node_id = _of("nodes.id", "where it ends")
    length_m = Column(Float, nullable=False, comment="[m] along its course")


class ClipRow(Base):
    """A clip."""

    __tablename__ = "clips"
    __table_args__ = _table(
        "what holds the wires that pass it, on a segment or at a node",
        UniqueConstraint("product_id", "name"),
        CheckConstraint("(segment_id IS NULL) <> (node_id IS NULL)", name="place"),
        CheckConstraint("along >= 0 AND along <= 1", name="along"),
    )
    id = _key()
    product_id = _of("products.id", "that the clip is of")
    name = _text("unique in the product")
    kind = _text("its type, for a person; empty if it is not known")
    segment_id = _of("segments.id", "that it sits on; null if at a node", optional=True)
    along = Column(Float, nullable=False, comment="place on the segment, 0 at its start to 1")
    node_id = _of("nodes.id", "that it sits at; null if on a segment", optional=True)
    x_m, y_m, z_m = _numbers(3, "[m] place in the product's frame")


class ComponentRow(Base):
    """A device or a connector."""

    __tablename__ = "components"
    __table_args__ = _table(
        "devices with clamps and connectors with cavities", UniqueConstraint("product_id", "name")
    )
    id = _key()
    product_id = _of("products.id", "that it is part of")
    name = _text("designation, unique in the product")
    kind = _text("what it is, for a person")
    role = _text("device or connector")
    part_number = _text("of its article; empty if it is not known")
    mount = _text("plate (of the cabinet, or the board), door (of the cabinet) or outside")
    node_id = _of("nodes.id", "of the routes at which it sits; null if at none", optional=True)
    x_m, y_m, z_m = _numbers(3, "[m] place in the product's frame")
    qx, qy, qz, qw = _numbers(4, "unit quaternion of its frame in the product's")


class TerminalRow(Base):
    """A clamp or a cavity."""

    __tablename__ = "terminals"
    __table_args__ = _table(
        "clamps of devices and cavities of connectors, each for one wire end",
        UniqueConstraint("component_id", "name"),
        CheckConstraint("clearance_m >= 0", name="clearance"),
        CheckConstraint("insertion_force_limit_n > 0", name="insertion_force_limit"),
    )
    id = _key()
    component_id = _of("components.id", "that it is part of")
    name = _text("unique in the component")
    side = _text("top or bottom, on which it opens as drawn")
    point = _text("of the drawing that it shares with other terminals; empty if with none")
    kind = _text("its type, such as the article of the contact; empty if it is not known")
    x_m, y_m, z_m = _numbers(3, "[m] place of its opening in the component's frame")
    qx, qy, qz, qw = _numbers(4, "unit quaternion of its frame in the component's")
    approach_x, approach_y, approach_z = _numbers(
        3, "unit vector by which an end goes in, component's frame"
    )
    clearance_m = _number("[m] that a gripper needs around the opening")
    insertion_force_limit_n = _number("[N] that an insertion must not exceed")


class CableRow(Base):
    """A cable."""

    __tablename__ = "cables"
    __table_args__ = _table(
        "cables, whose cores and shields are wires", UniqueConstraint("product_id", "name")
    )
    id = _key()
    product_id = _of("products.id", "that it is part of")
    name = _text("unique in the product")
    kind = _text("its type or article; empty if it is not known")
    length_m = _number("[m]")
    shielded = Column(Boolean, nullable=False, comment="whether it has a shield")
    source = _text("place in the design file")


class WireRow(Base):
    """A wire or a core."""

    __tablename__ = "wires"
    __table_args__ = _table(
        "single wires and cores of cables, each between two terminals",
        UniqueConstraint("product_id", "name"),
        UniqueConstraint("a_terminal_id"),
        UniqueConstraint("b_terminal_id"),
        CheckConstraint("a_terminal_id <> b_terminal_id", name="ends"),
        CheckConstraint("section_mm2 > 0", name="section"),
    )
    id = _key()
    product_id = _of("products.id", "that it is part of")
    name = _text("number or designation, unique in the product")
    number = Column(
        String,
        nullable=False,
        server_default="",
        comment="that the design gives it; several wires may have the same; empty if none",
    )
    a_terminal_id = _of("terminals.id", "that its end a is placed in")
    b_terminal_id = _of("terminals.id", "that its end b is placed in")
    colour = _text("IEC 60757 code; of several colours one after another; empty of a shield")
    section_mm2 = Column(Float, nullable=False, comment="[mm^2] of the conductor")
    length_m = _number("[m] from tip to tip")
    cable_id = _of("cables.id", "that it is a core of; null of a single wire", optional=True)
    core = _text("its name in the cable; empty of a single wire")
    source = _text("place in the design file")


class RouteRow(Base):
    """A step of a wire's route."""

    __tablename__ = "routes"
    __table_args__ = _table("the segments that each wire passes, from its end a to its end b")
    wire_id = _of("wires.id", "that passes", key=True)
    position = Column(
        Integer, primary_key=True, autoincrement=False, comment="in the route, from 0"
    )
    segment_id = _of("segments.id", "that is passed")


class OrderRow(Base):
    """An order."""

    __tablename__ = "orders"
    __table_args__ = _table("what is to be built now", UniqueConstraint("name"))
    id = _key()
    name = _text("by which people call the order")
    product_id = _of("products.id", "that is to be built")
    units = Column(
        Integer, nullable=False, default=0, comment="how many products of it were begun so far"
    )


class RehearsalRow(Base):
    """A rehearsal."""

    __tablename__ = "rehearsals"
    __table_args__ = _table("trials of orders in the simulated cell")
    id = _key()
    order_id = _of("orders.id", "that was rehearsed")
    made = Column(DateTime, nullable=False, comment="wall time, UTC")
    data = Column(
        PackedJson,
        nullable=False,
        comment="wires, trials and calls of abilities, as remodel_run/rehearsal.py has them",
    )


class PreferenceRow(Base):
    """A preference of an order."""

    __tablename__ = "preferences"
    __table_args__ = _table(
        "what the user prefers of an order's plan; a plan may break it, and pays",
        UniqueConstraint("order_id", "section", "position"),
    )
    id = _key()
    order_id = _of("orders.id", "whose plan it is about")
    section = _text("of the preferences' document: prefer, or weights")
    position = Column(Integer, nullable=False, comment="in its section, from 0")
    name = _text("the user's name for it; empty if it has none")
    rule = Column(JSON, nullable=False, comment="the entry, as in the document")


class ConstraintRow(Base):
    """A constraint of an order."""

    __tablename__ = "constraints"
    __table_args__ = _table(
        "what the user requires of an order's plan; no plan breaks it",
        UniqueConstraint("order_id", "section", "position"),
    )
    id = _key()
    order_id = _of("orders.id", "whose plan it is about")
    section = _text("of the preferences' document: require")
    position = Column(Integer, nullable=False, comment="in its section, from 0")
    name = _text("the user's name for it; empty if it has none")
    rule = Column(JSON, nullable=False, comment="the entry, as in the document")


class TaskRow(Base):
    """A task."""

    __tablename__ = "tasks"
    __table_args__ = _table(
        "what an order asks of the cell: one wire to be placed each",
        UniqueConstraint("order_id", "wire_id"),
    )
    id = _key()
    order_id = _of("orders.id", "that it is part of")
    wire_id = _of("wires.id", "that is to be placed")
    state = _text("open, begun, done or `set aside`")
    cell = _text("name of the cell that has begun it; empty if none has")
    lease_until = _number(
        "[s] since 1970 by the database's clock, until which the cell has it for itself"
    )
    token = Column(
        Integer, nullable=False, default=0, comment="of the cell's owner that has begun it; or 0"
    )


class AbilityRow(Base):
    """An ability."""

    __tablename__ = "abilities"
    __table_args__ = _table("what the cell can do, by its actions", UniqueConstraint("name"))
    id = _key()
    name = _text("of the action, such as InsertCable")
    description = _text("what it does, for a person")


class AbilityParameterRow(Base):
    """A parameter of an ability."""

    __tablename__ = "ability_parameters"
    __table_args__ = _table(
        "the parameters of an ability's goal", UniqueConstraint("ability_id", "name")
    )
    id = _key()
    ability_id = _of("abilities.id", "that takes it")
    position = Column(Integer, nullable=False, comment="in the goal, from 0")
    name = _text("of the goal's field")
    type = _text("of the goal's field, as ROS messages name it")
    description = _text("with unit and frame, for a person")


class CellRow(Base):
    """A cell."""

    __tablename__ = "cells"
    __table_args__ = _table("which supervisor owns each cell; one at a time may act and record")
    name = Column(String, primary_key=True, comment="of the cell")
    token = Column(
        Integer, nullable=False, comment="number of the ownership, which grows by 1 with each"
    )
    station = _text("that owns it, or owned it last; it may take over from itself at once")
    holder = _text("the supervisor's host, process and ROS master, for persons")
    lease_until = Column(
        Float,
        nullable=True,
        comment="[s] since 1970 by the database's clock, until which no other station may own it; "
        "null if it has no owner",
    )


class RunRow(Base):
    """A run."""

    __tablename__ = "runs"
    __table_args__ = _table("attempts to build an order, or part of it")
    id = _key()
    order_id = _of("orders.id", "that was run")
    started = Column(DateTime, nullable=False, comment="wall time, UTC")
    cell = _text("name of the cell that does it")
    ended = Column(Boolean, nullable=False, comment="or not")
    owner = Column(
        Integer, nullable=False, default=0, comment="token of the cell's owner that does it"
    )
    events = Column(Integer, nullable=False, default=0, comment="how many it has so far")
    serial = Column(
        String,
        nullable=False,
        default="",
        index=True,
        comment="serial number of the product; empty if not known",
    )


class ChartRow(Base):
    """A chart."""

    __tablename__ = "charts"
    __table_args__ = _table("charts of behaviors that runs have begun, each once")
    hash = Column(String, primary_key=True, comment="SHA-256 of the chart")
    xml = Column(PackedText, nullable=False, comment="the chart")


class RunEventRow(Base):
    """An event."""

    __tablename__ = "run_events"
    __table_args__ = _table(
        "what happened in runs; rows are added, and never changed",
        UniqueConstraint("run_id", "position"),
    )
    id = _key()
    run_id = _of("runs.id", "in which it happened", index=False)
    position = Column(Integer, nullable=False, comment="in the run, from 0")
    at = Column(DateTime, nullable=False, comment="wall time, UTC")
    kind = _text("of the event, such as TaskBegun")
    data = Column(
        PackedJson, nullable=False, comment="its fields, by name; a chart by its hash (chart_hash)"
    )


class RunSnapshotRow(Base):
    """A snapshot."""

    __tablename__ = "run_snapshots"
    __table_args__ = _table("the state of each run after some of its events, to resume it sooner")
    run_id = _of("runs.id", "whose state it is", key=True)
    events = Column(Integer, nullable=False, comment="how many events it covers")
    data = Column(PackedJson, nullable=False, comment="the state, with the version of its form")


class ExecutionRow(Base):
    """An execution."""

    __tablename__ = "executions"
    __table_args__ = _table("executions of the behaviors of tasks")
    id = _key()
    run_id = _of("runs.id", "that it was part of")
    task_id = _of("tasks.id", "whose behavior was executed")
    behavior = _text("its name")
    attempt = Column(Integer, nullable=False, comment="at the task in this run, from 1")
    outcome = _text("of the behavior, or how it ended without one")
    placed = Column(Boolean, nullable=False, comment="whether the cell found the wire placed")
    started_s = Column(Float, nullable=False, comment="[s] ROS time")
    ended_s = Column(Float, nullable=False, comment="[s] ROS time")


class AbilityRecordRow(Base):
    """A record of an ability."""

    __tablename__ = "ability_records"
    __table_args__ = _table("executions of abilities, as remodel_msgs/AbilityRecord reports them")
    id = _key()
    execution_id = _of("executions.id", "that it was part of")
    state_path = _text("of the state in the behavior")
    ability = _text("its name")
    outcome = _text("of the state; empty when it was left without one")
    error_code = Column(Integer, nullable=False, comment="remodel_msgs/ErrorCode, 0 for none")
    ended_s = Column(Float, nullable=False, comment="[s] ROS time")
    elapsed_s = Column(Float, nullable=False, comment="[s] ROS time")
    position = Column(
        Integer,
        nullable=True,
        comment="of its event in the run, which has the rest; null in runs of older programs",
    )
    data = Column(
        PackedJson,
        nullable=True,
        comment="text, goal_id, parameters and measurements; null if an event has them",
    )


class DecisionRow(Base):
    """A decision."""

    __tablename__ = "decisions"
    __table_args__ = _table("what was done about executions that failed, and why")
    id = _key()
    execution_id = _of("executions.id", "that failed")
    fault = _text("kind of fault, as in remodel_msgs/config/faults.yaml")
    error_code = Column(Integer, nullable=False, comment="remodel_msgs/ErrorCode that decided it")
    evidence = _text("what the ability, or the engine, said")
    response = _text("what was done, as in remodel_msgs/config/faults.yaml")
    because = _text("the reason, a sentence")
