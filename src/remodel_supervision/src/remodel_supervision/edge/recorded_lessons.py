"""What the records of all runs teach: calls of abilities, and responses to faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import groupby

from sqlalchemy import and_, select
from sqlalchemy.engine import Connection

from remodel_production.core.production import terminal_type
from remodel_production.edge.database.production_database import ProductionDatabase, rehearsals
from remodel_production.edge.database.production_models import (
    AbilityRecordRow,
    ComponentRow,
    DecisionRow,
    ExecutionRow,
    RunEventRow,
    TaskRow,
    TerminalRow,
    WireRow,
)
from remodel_supervision.core.learning.experience import (
    REHEARSED_WEIGHT,
    Call,
    TriedResponse,
    numbers_from,
    tried_responses,
)
from remodel_tasks.core.condition import Value, terminal_features
from remodel_tasks.core.task_charts.task_chart import FINISHED
from remodel_tasks.core.use_case.fault import Do

# How many records are decoded at once.
_READ_AT_ONCE = 1000

# A product's number, a component and its terminal, by name.
_Place = tuple[int, str, str]


def ability_calls(database: ProductionDatabase) -> tuple[Call, ...]:
    """Return all calls of abilities: those of rehearsals, which count less, then all recorded.

    They are in this order so that what the robot does outweighs what was rehearsed.
    """
    with database.reading() as connection:
        return (*_rehearsed_calls(connection), *_recorded_calls(connection))


def _rehearsed_calls(connection: Connection) -> Iterator[Call]:
    for rehearsal in rehearsals(connection):
        for each in rehearsal.calls:
            yield Call(
                each.ability,
                each.features,
                each.error_code,
                each.elapsed_s,
                parameters=each.parameters,
                weight=REHEARSED_WEIGHT,
            )


def _recorded_calls(connection: Connection) -> tuple[Call, ...]:
    terminals = _terminal_features(connection)
    rows = connection.execute(
        select(
            AbilityRecordRow.ability,
            WireRow.product_id,
            WireRow.section_mm2,
            WireRow.colour,
            AbilityRecordRow.error_code,
            AbilityRecordRow.elapsed_s,
            AbilityRecordRow.data,
            RunEventRow.data,
        )
        .join(ExecutionRow, AbilityRecordRow.execution_id == ExecutionRow.id)
        .outerjoin(
            RunEventRow,
            and_(
                RunEventRow.run_id == ExecutionRow.run_id,
                RunEventRow.position == AbilityRecordRow.position,
            ),
        )
        .join(TaskRow, ExecutionRow.task_id == TaskRow.id)
        .join(WireRow, TaskRow.wire_id == WireRow.id)
        .order_by(AbilityRecordRow.id)
        .execution_options(yield_per=_READ_AT_ONCE)
    )
    calls = []
    # Shared by calls that have the same: there are tens of thousands of calls, and few of these.
    features: dict[tuple[_Place, float, str], dict[str, Value]] = {}
    settings: dict[tuple[tuple[str, float], ...], Mapping[str, float]] = {}
    for ability, product, section, colour, code, elapsed_s, record, event in rows:
        given = dict((record or event["operation"])["parameters"])
        place = (product, given.get("component_id", ""), given.get("terminal_id", ""))
        about = (place, section, colour)
        if about not in features:
            own = {"section_mm2": section, "colour": colour}
            features[about] = own | terminals.get(place, {})
        found = numbers_from(given.items())
        numbers = settings.setdefault(tuple(found.items()), found)
        calls.append(Call(ability, features[about], code, elapsed_s, parameters=numbers))
    return tuple(calls)


def recorded_responses(connection: Connection) -> tuple[TriedResponse, ...]:
    """Return what was done about faults in any run, and whether it helped, in order of the tasks.

    A response whose task is still under way is left out.
    """
    rows = connection.execute(
        select(
            ExecutionRow.run_id,
            ExecutionRow.task_id,
            ExecutionRow.attempt,
            ExecutionRow.outcome,
            DecisionRow.fault,
            DecisionRow.response,
        )
        .outerjoin(DecisionRow, DecisionRow.execution_id == ExecutionRow.id)
        .order_by(ExecutionRow.run_id, ExecutionRow.task_id, ExecutionRow.id)
    )
    responses: list[TriedResponse] = []
    for _, of_task in groupby(rows, key=lambda row: (row.run_id, row.task_id)):
        executions = list(of_task)
        decided = [row for row in executions if row.fault is not None]
        # Emptying the hand belongs to the attempt before.
        last = max((row.attempt for row in decided), default=0)
        finished = any(row.outcome == FINISHED and row.attempt > last for row in executions)
        decisions = [(row.fault, Do(row.response)) for row in decided]
        responses += tried_responses(decisions, finished=finished)
    return tuple(responses)


def _terminal_features(connection: Connection) -> dict[_Place, dict[str, Value]]:
    rows = connection.execute(
        select(
            ComponentRow.product_id,
            ComponentRow.name,
            TerminalRow.name,
            TerminalRow.kind,
            ComponentRow.part_number,
            ComponentRow.kind,
            TerminalRow.approach_x,
            TerminalRow.approach_y,
            TerminalRow.approach_z,
        ).join(ComponentRow, TerminalRow.component_id == ComponentRow.id)
    )
    return {
        (product, component, terminal): terminal_features(
            terminal_type(*kinds), None if x is None else (x, y, z)
        )
        for product, component, terminal, *kinds, x, y, z in rows
    }
