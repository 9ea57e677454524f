"""Read a use case from its parsed document.

Its form has been checked against config/use_case.schema.json. Here the names are checked: each
reference has a target, and neither decomposition nor observation is circular.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from remodel_tasks.core.condition import Condition, Test
from remodel_tasks.core.problem.defects import cycle_in
from remodel_tasks.core.use_case.fault import policy_from
from remodel_tasks.core.use_case.model import (
    INSERTED,
    Action,
    Bounds,
    CellTimes,
    Characteristic,
    ControlRule,
    Fact,
    Frozen,
    FrozenExpectations,
    Macro,
    Method,
    Scope,
    Subtask,
    UseCase,
    designs_from,
    settings,
)
from remodel_tasks.errors import UseCaseError

Json = dict[str, Any]

_REQUIRED = (Macro.PICK, Macro.INSERT, Macro.ROUTE, Macro.FIX)
# What every task has, besides what the use case declares; the end where one is inserted.
_COMPUTED = ("length_m", "clips", INSERTED)


def use_case_from(data: Json) -> UseCase:
    """Return the use case of a document that has the schema's form.

    Raises:
        UseCaseError: with all names that refer to nothing, and circles.
    """
    stated = data["characteristics"]
    use_case = UseCase(
        name=data["name"],
        title=data["title"],
        description=data["description"],
        task_characteristics=_characteristics(stated.get("task", {})),
        component_characteristics=_characteristics(stated.get("component", {})),
        heavy=_condition(data.get("heavy", {})),
        facts={
            name: Fact(name, Scope(item["of"]), item["look"])
            for name, item in data.get("unknown", {}).items()
        },
        expectations=FrozenExpectations(
            {name: _frozen(item) for name, item in data["abilities"].items()}
        ),
        learned={name: _bounds(name, item) for name, item in data.get("learned", {}).items()},
        actions={name: _action(name, item) for name, item in data["actions"].items()},
        methods={task: tuple(map(_method, methods)) for task, methods in data["methods"].items()},
        rules=tuple(
            ControlRule(item["name"], item["never"], _condition(item.get("when", {})))
            for item in data.get("rules", [])
        ),
        cell=CellTimes(**data["cell"]),
        give_up=tuple(_several(data["give_up"])),
        discard=data.get("discard", ""),
        preferences=data.get("preferences", {}),
        recovery=policy_from(data.get("recovery", {})),
        designs=designs_from(data.get("designs")),
    )
    findings = list(_unknown_names(use_case)) or [*_hidden_facts(use_case), *_circles(use_case)]
    if findings:
        raise UseCaseError("\n  ".join(findings))
    return use_case


def _bounds(ability: str, stated: Json) -> dict[str, Bounds]:
    """Return the bounds of an ability's parameters; UseCaseError if they are invalid."""
    try:
        bounds = {
            name: Bounds(item["frozen"], item["at_least"], item["at_most"], item["values"])
            for name, item in stated.items()
        }
        settings(bounds)
    except ValueError as error:
        raise UseCaseError(f"learned.{ability}: {error}") from error
    return bounds


def _characteristics(stated: Json) -> dict[str, Characteristic]:
    return {
        name: Characteristic(
            name,
            item["default"],
            tuple(item.get("one_of", ())),
            item.get("at_least", float("-inf")),
            most=item.get("at_most", float("inf")),
        )
        for name, item in stated.items()
    }


def _condition(stated: Json) -> Condition:
    return Condition(tuple(Test.stated(name, asked) for name, asked in stated.items()))


def _frozen(stated: Json | list[Json]) -> tuple[Frozen, ...]:
    items = stated if isinstance(stated, list) else [stated]
    return tuple(
        Frozen(
            _condition(item.get("when", {})),
            item["duration_s"],
            item.get("per_m_s", 0.0),
            item["success"],
        )
        for item in items
    )


def _action(name: str, item: Json) -> Action:
    return Action(
        name=name,
        title=item["title"],
        type=item.get("state") or item["behavior"],
        is_behavior="behavior" in item,
        done=tuple(_several(item["done"])),
        abilities=tuple(item["abilities"]),
        tool=item.get("tool", ""),
        force_n=float(item.get("force_n", 0.0)),
        needs=_named(item.get("needs", ())),
        reveals=_named(item.get("reveals", ())),
        forgets=tuple(item.get("forgets", ())),
        grasps=item.get("grasps", False),
        inputs=tuple(item.get("inputs", {}).items()),
        params=tuple(item.get("params", {}).items()),
        attempts=item.get("attempts", 1),
        recover=item.get("recover", ""),
        on_failure=item.get("on_failure", ""),
    )


def _several(stated: str | list[str]) -> list[str]:
    return [stated] if isinstance(stated, str) else stated


def _named(stated: Json | list[str]) -> tuple[tuple[str, str], ...]:
    """Return facts with the inputs or outputs that carry them; a list names facts alone."""
    if isinstance(stated, dict):
        return tuple(stated.items())
    return tuple((fact, "") for fact in stated)


def _method(item: Json) -> Method:
    subtasks = tuple(
        Subtask(sub) if isinstance(sub, str) else Subtask(sub["for_each_clip"], True)
        for sub in item["do"]
    )
    when, if_cheaper = _condition(item.get("when", {})), item.get("if_cheaper", False)
    return Method(item["name"], when, if_cheaper, subtasks)


def _unknown_names(use_case: UseCase) -> Iterator[str]:
    actions, facts = use_case.actions, use_case.facts
    tasks = [macro.value for macro in _REQUIRED if macro.value not in use_case.methods]
    yield from (f"methods: none for {task}, of which every task is made" for task in tasks)
    yield from _missing("give_up", use_case.give_up, actions, "action")
    discard = [use_case.discard] if use_case.discard else []
    yield from _missing("discard", discard, actions, "action")
    for name, fact in facts.items():
        yield from _missing(f"unknown.{name}.look", [fact.look], actions, "action")
        revealed = [f for f, _ in actions[fact.look].reveals] if fact.look in actions else [name]
        if name not in revealed:
            yield f"unknown.{name}.look: {fact.look} does not reveal it"
    for name, action in actions.items():
        where = f"actions.{name}"
        yield from _missing(
            f"{where}.abilities", action.abilities, use_case.expectations.stated, "ability"
        )
        yield from _missing(f"{where}.needs", [f for f, _ in action.needs], facts, "unknown fact")
        yield from _missing(
            f"{where}.reveals", [f for f, _ in action.reveals], facts, "unknown fact"
        )
        yield from _missing(f"{where}.forgets", action.forgets, facts, "unknown fact")
        for key, named in (("recover", action.recover), ("on_failure", action.on_failure)):
            yield from _missing(f"{where}.{key}", [named] if named else [], actions, "action")
    for task, methods in use_case.methods.items():
        if task in actions:
            yield f"methods.{task}: an action has this name too"
        for method in methods:
            where = f"methods.{task}.{method.name}"
            known = {*actions, *use_case.methods}
            yield from _missing(where, [sub.name for sub in method.subtasks], known, "task")
            yield from _features(f"{where}.when", method.when, use_case)
    for rule in use_case.rules:
        yield from _missing(f"rules.{rule.name}.never", [rule.never], actions, "action")
        yield from _features(f"rules.{rule.name}.when", rule.when, use_case)
    yield from _features("heavy", use_case.heavy, use_case)
    yield from _missing("learned", use_case.learned, use_case.expectations.stated, "ability")
    for ability, stated in use_case.expectations.stated.items():
        for frozen in stated:
            yield from _features(f"abilities.{ability}.when", frozen.when, use_case)
        if stated[-1].when.tests:
            yield f"abilities.{ability}: the last entry must have no `when`, to stand for the rest"


def _features(where: str, condition: Condition, use_case: UseCase) -> Iterator[str]:
    known = {*_COMPUTED, *use_case.task_characteristics}
    known |= {f"component.{name}" for name in use_case.component_characteristics}
    yield from _missing(where, [test.name for test in condition.tests], known, "characteristic")


def _missing(where: str, names: Iterable[str], known: Iterable[str], what: str) -> Iterator[str]:
    there = sorted(known)
    for name in names:
        if name not in there:
            yield f"{where}: no {what} {name}; there are {', '.join(there) or 'none'}"


def _hidden_facts(use_case: UseCase) -> Iterator[str]:
    """Find actions that take a value from actions that name no output for it."""
    for action in use_case.actions.values():
        for fact in [fact for fact, key in action.needs if key]:
            for source in use_case.actions.values():
                if (fact, "") in source.reveals:
                    yield (
                        f"actions.{source.name}.reveals: name the output that carries {fact}, "
                        f"which {action.name} takes"
                    )


def _circles(use_case: UseCase) -> Iterator[str]:
    """Find tasks that are parts of themselves, and observations that undo each other."""
    looks = {name: use_case.actions[fact.look] for name, fact in use_case.facts.items()}
    parts = {
        task: {sub.name for method in methods for sub in method.subtasks}
        for task, methods in use_case.methods.items()
    }
    for name, action in use_case.actions.items():
        parts[name] = {looks[fact].name for fact, _ in action.needs}
    cycle = cycle_in(parts)
    if cycle:
        yield "decomposition without end: " + " needs ".join(cycle)
        return
    for action in use_case.actions.values():
        needs = [fact for fact, _ in action.needs]
        undoes = {f: _forgotten(looks[f], looks).intersection(needs) for f in needs}
        cycle = cycle_in(undoes)
        if cycle:
            yield f"{action.name} is never ready: observing {' undoes '.join(cycle)}"


def _forgotten(action: Action, looks: dict[str, Action]) -> set[str]:
    """Return the facts that an action, and the observations that it needs, invalidate."""
    forgotten = set(action.forgets)
    for fact, _ in action.needs:
        forgotten |= _forgotten(looks[fact], looks)
    return forgotten - {fact for fact, _ in action.reveals}
