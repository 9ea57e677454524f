"""What was done to one product: operation by operation, by which run, attempt and force."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from datetime import UTC, datetime

from remodel_production.core.production import Order, TerminalRef, Wire
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    Event,
    OperationEnded,
    StopReported,
    TaskBegun,
)

# What stands in place of an ability where an operator acted.
OPERATOR = "operator"


@dataclass(frozen=True)
class ProductEntry:
    """One operation on a product, or one answer of an operator about it.

    Attributes:
        kept_at: wall time at which it was kept, ISO 8601, UTC.
        ended_s: [s] ROS time; None of an answer.
        attempt: at the task in its run, from 1; 0 before the first.
        part: of the task that the behavior does: whole, again, rest, clear or discard.
        end: letter of the wire's end; empty if it is about both, or none.
        ability: such as "InsertCable", or "operator".
        result: outcome of the state, or the operator's answer.
        force_limit_n: [N] at which the insertion stops; None if it has none.
        peak_force_n: [N] largest force of the insertion; None if it was not measured.
        parameters: of the goal, name -> value as text.
        measurements: of the result, name -> value as text.
    """

    serial: str
    run: int
    cell: str
    kept_at: str
    ended_s: float | None
    elapsed_s: float | None
    task: str
    attempt: int
    part: str
    behavior: str
    state_path: str
    end: str
    ability: str
    goal_id: str
    result: str
    error_code: int
    text: str
    force_limit_n: float | None
    peak_force_n: float | None
    parameters: Mapping[str, str]
    measurements: Mapping[str, str]


def product_entries(
    serial: str, run: int, cell: str, order: Order, events: Iterable[tuple[datetime, Event]]
) -> Iterator[ProductEntry]:
    """Yield what a run did to its product.

    Args:
        serial: number of the product.
        run: number of the run.
        cell: that did it.
        order: that the product is of; of its wires, which end belongs in which terminal.
        events: of the run, each with the wall time (UTC) at which it was kept.
    """
    wires = {wire.name: wire for wire in order.wires}
    begun: dict[str, TaskBegun] = {}
    asked: Asked | None = None
    for at, event in events:
        who = (serial, run, cell, at.replace(tzinfo=UTC).isoformat(timespec="milliseconds"))
        match event:
            case TaskBegun():
                begun[event.task] = event
            case OperationEnded() | StopReported():
                behavior = begun.get(event.task)
                wire = wires.get(event.task)
                yield _of_operation(who, event.task, behavior, wire, operation=event.operation)
            case Asked():
                asked = event
            case Answered() if asked is not None:
                yield _of_answer(who, begun.get(asked.task), asked, event)


_Who = tuple[str, int, str, str]


def _of_operation(
    who: _Who, task: str, begun: TaskBegun | None, wire: Wire | None, operation: Operation
) -> ProductEntry:
    parameters, measurements = dict(operation.parameters), dict(operation.measurements)
    return ProductEntry(
        *who,
        ended_s=operation.ended_s,
        elapsed_s=operation.elapsed_s,
        task=task,
        attempt=begun.attempt if begun else 0,
        part=begun.part.value if begun else "",
        behavior=begun.behavior if begun else "",
        state_path=operation.state_path,
        end=parameters.get("cable_end") or _end_at(wire, parameters),
        ability=operation.ability,
        goal_id=operation.goal_id,
        result=operation.outcome,
        error_code=operation.error_code,
        text=operation.text,
        force_limit_n=_number(parameters.get("force_limit")),
        peak_force_n=_number(measurements.get("peak_force")),
        parameters=parameters,
        measurements=measurements,
    )


def _of_answer(who: _Who, begun: TaskBegun | None, asked: Asked, event: Answered) -> ProductEntry:
    return ProductEntry(
        *who,
        ended_s=None,
        elapsed_s=None,
        task=asked.task,
        attempt=begun.attempt if begun else 0,
        part=begun.part.value if begun else "",
        behavior=begun.behavior if begun else "",
        state_path="",
        end="",
        ability=OPERATOR,
        goal_id="",
        result=event.choice.value,
        error_code=0,
        text=f"{event.by} answered question {asked.number}: {asked.text}",
        force_limit_n=None,
        peak_force_n=None,
        parameters={},
        measurements={},
    )


def _end_at(wire: Wire | None, parameters: Mapping[str, str]) -> str:
    """Return the letter of the end that belongs in the terminal that parameters name."""
    place = TerminalRef(parameters.get("component_id", ""), parameters.get("terminal_id", ""))
    ends = {} if wire is None else {wire.a: "a", wire.b: "b"}
    return ends.get(place, "")


def _number(text: str | None) -> float | None:
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


COLUMNS = tuple(each.name for each in fields(ProductEntry))


def as_csv(entries: Iterable[ProductEntry]) -> str:
    """Return entries as CSV (RFC 4180) with a header; mappings are JSON, None is empty."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(COLUMNS)
    for entry in entries:
        values = (getattr(entry, name) for name in COLUMNS)
        writer.writerow([_json(value) if isinstance(value, Mapping) else value for value in values])
    return text.getvalue()


def as_json(serial: str, entries: Iterable[ProductEntry]) -> str:
    """Return entries as one JSON document."""
    rows = [{name: getattr(entry, name) for name in COLUMNS} for entry in entries]
    document = {"format": "remodel-product-1", "serial": serial, "entries": rows}
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
