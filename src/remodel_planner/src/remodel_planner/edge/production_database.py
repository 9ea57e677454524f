"""The production knowledge database: orders, what they are made of, and what was done.

    orders ─ components ─ terminals          what is to be built (importers write it)
           ├ wires (two terminals each)
           └ notes
    runs ─ executions ─ ability_records      what was done (the supervisor writes it)
             └ of a wire, by a behavior

SQLite by default, any database that SQLAlchemy knows by URL. Every change is one transaction.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import (
    Boolean,
    Column,
    DateTime,
    Float,
    ForeignKey,
    Integer,
    String,
    UniqueConstraint,
    create_engine,
    event,
    select,
)
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session, declarative_base, relationship

from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.run import Execution, Operation
from remodel_planner.errors import OrderError

Base = declarative_base()


class OrderRow(Base):
    """An order."""

    __tablename__ = "orders"
    id = Column(Integer, primary_key=True)
    name = Column(String, nullable=False, unique=True)
    title = Column(String, nullable=False, doc="of the design")
    source = Column(String, nullable=False, doc="the design's file name")
    components = relationship(
        "ComponentRow", order_by="ComponentRow.id", cascade="all, delete-orphan"
    )
    wires = relationship("WireRow", order_by="WireRow.id", cascade="all, delete-orphan")
    notes = relationship("NoteRow", order_by="NoteRow.id", cascade="all, delete-orphan")
    runs = relationship("RunRow", order_by="RunRow.id", cascade="all, delete-orphan")


class ComponentRow(Base):
    """A device mounted in the cabinet."""

    __tablename__ = "components"
    __table_args__ = (UniqueConstraint("order_id", "name"),)
    id = Column(Integer, primary_key=True)
    order_id = Column(ForeignKey("orders.id"), nullable=False)
    name = Column(String, nullable=False)
    kind = Column(String, nullable=False, doc="for a person")
    terminals = relationship("TerminalRow", order_by="TerminalRow.id", cascade="all, delete-orphan")


class TerminalRow(Base):
    """A clamp that takes one wire end."""

    __tablename__ = "terminals"
    __table_args__ = (UniqueConstraint("component_id", "name"),)
    id = Column(Integer, primary_key=True)
    component_id = Column(ForeignKey("components.id"), nullable=False)
    name = Column(String, nullable=False)
    side = Column(String, nullable=False, doc="top or bottom")
    point = Column(String, nullable=False, doc="shared with other clamps, or empty")
    component = relationship("ComponentRow", back_populates="terminals")


class WireRow(Base):
    """A wire between two terminals."""

    __tablename__ = "wires"
    __table_args__ = (UniqueConstraint("order_id", "name"),)
    id = Column(Integer, primary_key=True)
    order_id = Column(ForeignKey("orders.id"), nullable=False)
    name = Column(String, nullable=False)
    a_terminal_id = Column(ForeignKey("terminals.id"), nullable=False, unique=True)
    b_terminal_id = Column(ForeignKey("terminals.id"), nullable=False, unique=True)
    colour = Column(String, nullable=False, doc="IEC 60757 code")
    section_mm2 = Column(Float, nullable=False)
    source = Column(String, nullable=False, doc="place in the design file")
    a_terminal = relationship("TerminalRow", foreign_keys=[a_terminal_id])
    b_terminal = relationship("TerminalRow", foreign_keys=[b_terminal_id])


class NoteRow(Base):
    """What the import of an order guessed or left out."""

    __tablename__ = "notes"
    id = Column(Integer, primary_key=True)
    order_id = Column(ForeignKey("orders.id"), nullable=False)
    text = Column(String, nullable=False)


class RunRow(Base):
    """One run of an order."""

    __tablename__ = "runs"
    id = Column(Integer, primary_key=True)
    order_id = Column(ForeignKey("orders.id"), nullable=False)
    started = Column(DateTime, nullable=False, doc="wall time")
    executions = relationship(
        "ExecutionRow", order_by="ExecutionRow.id", cascade="all, delete-orphan"
    )


class ExecutionRow(Base):
    """One execution of a wire's behavior."""

    __tablename__ = "executions"
    id = Column(Integer, primary_key=True)
    run_id = Column(ForeignKey("runs.id"), nullable=False)
    wire_id = Column(ForeignKey("wires.id"), nullable=False)
    behavior = Column(String, nullable=False)
    attempt = Column(Integer, nullable=False, doc="at placing the wire, from 1")
    outcome = Column(String, nullable=False, doc="of the behavior, or how it ended without one")
    placed = Column(Boolean, nullable=False, doc="by the simulated cell's ground truth")
    started_s = Column(Float, nullable=False, doc="ROS time")
    ended_s = Column(Float, nullable=False, doc="ROS time")
    operations = relationship(
        "AbilityRecordRow", order_by="AbilityRecordRow.id", cascade="all, delete-orphan"
    )


class AbilityRecordRow(Base):
    """One execution of an ability, as remodel_msgs/AbilityRecord tells it."""

    __tablename__ = "ability_records"
    id = Column(Integer, primary_key=True)
    execution_id = Column(ForeignKey("executions.id"), nullable=False)
    state_path = Column(String, nullable=False)
    ability = Column(String, nullable=False)
    outcome = Column(String, nullable=False)
    error_code = Column(Integer, nullable=False)
    text = Column(String, nullable=False)
    ended_s = Column(Float, nullable=False, doc="ROS time")
    elapsed_s = Column(Float, nullable=False)


@dataclass(frozen=True)
class Run:
    """A run under way."""

    id: int
    order: Order


class ProductionDatabase:
    """The database's door: values in, values out."""

    def __init__(self, url: str) -> None:
        """Connect, and make the tables that are missing.

        Raises:
            OrderError: if there is no database at the URL.
        """
        try:
            self._engine = create_engine(url, future=True)
            event.listen(self._engine, "connect", _enforce_foreign_keys)
            Base.metadata.create_all(self._engine)
        except SQLAlchemyError as error:
            raise OrderError(f"database {url}: {str(error).splitlines()[0]}") from error

    def close(self) -> None:
        """Let go of the database."""
        self._engine.dispose()

    def add_order(self, order: Order) -> None:
        """Store an order, whole or not at all.

        Raises:
            OrderError: if there is one of that name already.
        """
        with self._transaction() as session:
            if session.scalar(select(OrderRow).filter_by(name=order.name)):
                raise OrderError(
                    f"the database has an order {order.name} already: give another name (--order)"
                )
            session.add(_order_row(order))

    def order(self, name: str) -> Order:
        """Return an order.

        Raises:
            OrderError: if there is none of that name.
        """
        with self._transaction() as session:
            row = session.scalar(select(OrderRow).filter_by(name=name))
            if row is None:
                known = ", ".join(session.scalars(select(OrderRow.name))) or "none"
                raise OrderError(f"the database has no order {name}; it has: {known}")
            return _order(row)

    def start_run(self, order: Order) -> Run:
        """Begin a run of an order."""
        with self._transaction() as session:
            row = session.scalars(select(OrderRow).filter_by(name=order.name)).one()
            run = RunRow(started=datetime.now())
            row.runs.append(run)
            session.flush()
            return Run(run.id, order)

    def add_execution(self, run: Run, execution: Execution) -> None:
        """Store how the execution of one wire's behavior went."""
        with self._transaction() as session:
            row = session.get(RunRow, run.id)
            wire = session.scalars(
                select(WireRow).filter_by(order_id=row.order_id, name=execution.wire)
            ).one()
            row.executions.append(
                ExecutionRow(
                    wire_id=wire.id,
                    behavior=execution.behavior,
                    attempt=execution.attempt,
                    outcome=execution.outcome,
                    placed=execution.placed,
                    started_s=execution.started_s,
                    ended_s=execution.ended_s,
                    operations=[_record_row(operation) for operation in execution.operations],
                )
            )

    @contextmanager
    def _transaction(self) -> Iterator[Session]:
        with Session(self._engine, future=True) as session, session.begin():
            yield session


def _enforce_foreign_keys(connection: object, _record: object) -> None:
    """SQLite checks foreign keys only when told to, connection by connection."""
    if type(connection).__module__.startswith("sqlite3"):
        connection.execute("PRAGMA foreign_keys=ON")  # type: ignore[attr-defined]


def _order_row(order: Order) -> OrderRow:
    components = [
        ComponentRow(
            name=component.name,
            kind=component.kind,
            terminals=[
                TerminalRow(name=t.name, side=t.side.value, point=t.point)
                for t in component.terminals
            ],
        )
        for component in order.components
    ]
    terminals = {
        TerminalRef(component.name, terminal.name): terminal
        for component in components
        for terminal in component.terminals
    }
    wires = [
        WireRow(
            name=wire.name,
            a_terminal=terminals[wire.a],
            b_terminal=terminals[wire.b],
            colour=wire.colour,
            section_mm2=wire.section_mm2,
            source=wire.source,
        )
        for wire in order.wires
    ]
    return OrderRow(
        name=order.name,
        title=order.title,
        source=order.source,
        components=components,
        wires=wires,
        notes=[NoteRow(text=text) for text in order.notes],
    )


def _order(row: OrderRow) -> Order:
    components = tuple(
        Component(
            component.name,
            component.kind,
            tuple(Terminal(t.name, Side(t.side), t.point) for t in component.terminals),
        )
        for component in row.components
    )
    wires = tuple(
        Wire(
            wire.name,
            _terminal_ref(wire.a_terminal),
            _terminal_ref(wire.b_terminal),
            wire.colour,
            wire.section_mm2,
            wire.source,
        )
        for wire in row.wires
    )
    notes = tuple(note.text for note in row.notes)
    return Order(row.name, row.title, row.source, components, wires, notes)


def _terminal_ref(row: TerminalRow) -> TerminalRef:
    return TerminalRef(row.component.name, row.name)


def _record_row(operation: Operation) -> AbilityRecordRow:
    return AbilityRecordRow(
        state_path=operation.state_path,
        ability=operation.ability,
        outcome=operation.outcome,
        error_code=operation.error_code,
        text=operation.text,
        ended_s=operation.ended_s,
        elapsed_s=operation.elapsed_s,
    )
