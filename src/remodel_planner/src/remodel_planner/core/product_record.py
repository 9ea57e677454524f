"""What was done to one product: operation by operation, by which run, attempt and force."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, datetime
from typing import Any

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


@dataclass(frozen=True, kw_only=True)
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
    ended_s: float | None = None
    elapsed_s: float | None = None
    task: str
    attempt: int
    part: str
    behavior: str
    state_path: str = ""
    end: str = ""
    ability: str
    goal_id: str = ""
    result: str
    error_code: int = 0
    text: str
    force_limit_n: float | None = None
    peak_force_n: float | None = None
    parameters: Mapping[str, str] = field(default_factory=dict)
    measurements: Mapping[str, str] = field(default_factory=dict)


def product_entries(
    serial: str, run: int, cell: str, order: Order, events: Iterable[tuple[datetime, Event]]
) -> Iterator[ProductEntry]:
    """Yield what a run did to its product, by its events, each with its wall time (UTC)."""
    wires = {wire.name: wire for wire in order.wires}
    begun: dict[str, TaskBegun] = {}
    asked: Asked | None = None

    def about(task: str, at: datetime) -> dict[str, Any]:
        behavior = begun.get(task)
        return {
            **{"serial": serial, "run": run, "cell": cell, "task": task},
            "kept_at": at.replace(tzinfo=UTC).isoformat(timespec="milliseconds"),
            "attempt": behavior.attempt if behavior else 0,
            "part": behavior.part.value if behavior else "",
            "behavior": behavior.behavior if behavior else "",
        }

    for at, event in events:
        match event:
            case TaskBegun():
                begun[event.task] = event
            case OperationEnded() | StopReported():
                wire = wires.get(event.task)
                yield _of_operation(about(event.task, at), wire, event.operation)
            case Asked():
                asked = event
            case Answered() if asked is not None:
                yield ProductEntry(
                    **about(asked.task, at),
                    ability=OPERATOR,
                    result=event.choice.value,
                    text=f"{event.by} answered question {asked.number}: {asked.text}",
                )


def _of_operation(
    about: Mapping[str, Any], wire: Wire | None, operation: Operation
) -> ProductEntry:
    parameters, measurements = dict(operation.parameters), dict(operation.measurements)
    return ProductEntry(
        **about,
        ended_s=operation.ended_s,
        elapsed_s=operation.elapsed_s,
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
        values = asdict(entry).values()
        writer.writerow([_json(value) if isinstance(value, dict) else value for value in values])
    return text.getvalue()


def as_json(serial: str, entries: Iterable[ProductEntry]) -> str:
    """Return entries as one JSON document."""
    rows = [asdict(entry) for entry in entries]
    document = {"format": "remodel-product-1", "serial": serial, "entries": rows}
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
