"""Abilities, error codes and faults of all packages, from their parsed tables and action files.

remodel_msgs/config/abilities.yaml and faults.yaml explain the fields; abilities.schema.json and
faults.schema.json, beside them, are their forms.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import jsonschema


class TableError(Exception):
    """A table of abilities or faults cannot be read or contradicts another one.

    Attributes:
        problems: every problem: its place in the file, what was found, and what is allowed.
    """

    def __init__(self, file: str, problems: Sequence[str]) -> None:
        """List every problem at once."""
        lines = "\n".join(f"  - {problem}" for problem in problems)
        count = f"{len(problems)} problem{'s' if len(problems) != 1 else ''}"
        super().__init__(f"{file}: {count}:\n{lines}")
        self.problems = tuple(problems)


# Explain where a document does not have the form of a JSON schema


_ALLOWED = {
    "type": "a value of type {}",
    "minimum": "{} or more",
    "maximum": "{} or less",
    "exclusiveMinimum": "more than {}",
    "minItems": "{} entries or more",
    "maxItems": "{} entries or fewer",
    "minProperties": "{} entries or more",
    "pattern": "text that matches {}",
}


def schema_problems(parsed: object, schema: dict[str, Any]) -> Iterator[str]:
    """Yield each problem: its place in the document, what was found and what is allowed."""
    import jsonschema  # loads a web client, and most commands check no document

    errors = jsonschema.Draft7Validator(schema).iter_errors(parsed)
    for error in sorted(errors, key=lambda error: [str(part) for part in error.absolute_path]):
        # Of alternatives (anyOf), the one that fits best.
        deepest = jsonschema.exceptions.best_match([error])
        yield f"{_place(deepest) or 'the file'}: {_explanation(deepest)}"
    yield from _not_finite(parsed, "")


def _place(error: jsonschema.ValidationError) -> str:
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path)
    return "".join(parts).lstrip(".")


def _explanation(error: jsonschema.ValidationError) -> str:
    """Return what was found and what is allowed."""
    found, rule = error.instance, error.validator_value
    if error.validator == "required":
        missing = ", ".join(name for name in rule if name not in found)
        return f"found {', '.join(map(str, found)) or 'nothing'}; missing: {missing}"
    if error.validator == "additionalProperties":
        allowed = error.schema["properties"]
        unknown = ", ".join(str(name) for name in found if name not in allowed)
        return f"found {unknown}; allowed: {', '.join(allowed)}"
    if error.validator == "enum":
        return f"found {found!r}; allowed: {', '.join(map(str, rule))}"
    if error.validator in _ALLOWED:
        return f"found {found!r}; allowed: {_ALLOWED[error.validator].format(rule)}"
    return str(error.message)


def _not_finite(value: object, place: str) -> Iterator[str]:
    """Yield the numbers that a schema accepts although they are NaN or infinite."""
    if isinstance(value, float) and not math.isfinite(value):
        yield f"{place}: found {value}; allowed: a finite number"
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _not_finite(item, f"{place}.{key}".lstrip("."))
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _not_finite(item, f"{place}[{i}]")


# Error codes and faults


# The package whose table belongs to the contract, and its numbers; other packages have the rest.
CONTRACT = "remodel_msgs"
CONTRACT_CODES = range(0, 500)
OTHER_CODES = range(1000, 10000)

Row = Mapping[str, Any]


@dataclass(frozen=True)
class ListedCode:
    """An error code; `package` is the one whose table lists it."""

    number: int
    name: str
    meaning: str
    remedy: str
    package: str


@dataclass(frozen=True)
class FaultTables:
    """What can go wrong, over all packages.

    Attributes:
        codes: by name, ordered by package, then number.
        faults: rows by name; `codes` are names, in rows with `after` too.
    """

    codes: Mapping[str, ListedCode]
    faults: Mapping[str, Row]

    @property
    def numbers(self) -> dict[str, int]:
        """The numbers of the codes by their names."""
        return {name: code.number for name, code in self.codes.items()}


def join_fault_tables(
    tables: Mapping[str, Sequence[Row]],
) -> tuple[FaultTables, list[str]]:
    """Return the tables of all packages as one, and what contradicts itself in them.

    Args:
        tables: package -> its parsed tables, in the form of the schema; the contract's first.
    """
    each = [(package, table) for package, own in tables.items() for table in own]
    listed = [code for package, table in each for code in _codes(package, table)]
    rows = [row for _, table in each for row in table.get("faults", [])]
    by_name = {row["fault"]: row for row in rows}
    problems = [*_wrong_numbers(listed), *_repeated(listed, rows)]
    problems += [
        f"fault {row['fault']}: after.fault {row['after']['fault']} is not a fault with codes"
        for row in rows
        if "after" in row and "codes" not in by_name.get(row["after"]["fault"], {})
    ]
    if problems:
        return FaultTables({}, {}), problems
    order = list(tables)
    listed.sort(key=lambda code: (order.index(code.package), code.number))
    faults = {name: {**row, "codes": _code_names(row, by_name)} for name, row in by_name.items()}
    return FaultTables({code.name: code for code in listed}, faults), []


def _codes(package: str, table: Row) -> Iterable[ListedCode]:
    groups = [table.get("no_fault", []), *(row.get("codes", []) for row in table.get("faults", []))]
    for row in (row for group in groups for row in group):
        yield ListedCode(row["code"], row["name"], row["meaning"], row["remedy"], package=package)


def _code_names(row: Row, by_name: Mapping[str, Row]) -> list[str]:
    source = by_name[row["after"]["fault"]] if "after" in row else row
    return [code["name"] for code in source["codes"]]


def _wrong_numbers(codes: Sequence[ListedCode]) -> Iterable[str]:
    for code in codes:
        allowed = CONTRACT_CODES if code.package == CONTRACT else OTHER_CODES
        if code.number not in allowed:
            yield (
                f"code {code.number} {code.name} of {code.package}: allowed: {allowed.start} to "
                f"{allowed.stop - 1}"
            )


def _repeated(codes: Sequence[ListedCode], rows: Sequence[Row]) -> Iterable[str]:
    seen: dict[object, ListedCode] = {}
    for code in codes:
        for key in (code.number, code.name):
            other = seen.setdefault(key, code)
            if other is not code:
                yield (
                    f"code {code.number} {code.name} of {code.package}: {key} is "
                    f"{other.number} {other.name} of {other.package} already"
                )
    names = [row["fault"] for row in rows]
    yield from (
        f"fault {n}: listed twice" for n in sorted({n for n in names if names.count(n) > 1})
    )


# Abilities


# Types of goal fields that a parameter of a state can give: ROS type -> type in the docstring.
PLAIN_TYPES = {"string": "string", "bool": "bool", "float64": "float", "uint8": "int"}
_DEFAULTS = {"string": (str,), "bool": (bool,), "float64": (int, float), "uint8": (int,)}
# Arguments of a state's constructor, and what the state keeps besides its parameters.
_PARAMETERS_TAKEN = (
    *("self", "timeout_s", "topic", "call", "execute", "input_keys", "is_controlled", "name"),
    *("outcomes", "output_keys", "own_userdata", "parent", "rate"),
)
_OUTPUTS_TAKEN = ("error_code", "error_message")
POSE = "geometry_msgs/PoseStamped"
POSES = f"{POSE}[]"


@dataclass(frozen=True)
class Parameter:
    """A parameter of a state: it gives a field of the goal; required if it has no default."""

    name: str
    field: Field
    default: bool | float | str | None = None

    @property
    def is_required(self) -> bool:
        """Whether a chart must give it."""
        return self.default is None


@dataclass(frozen=True)
class AbilityState:
    """The FlexBE state of an ability.

    Attributes:
        outcome: when the ability succeeds.
        means: what is true then, a sentence.
        inputs: fields of the goal that are userdata keys.
        parameters: required ones first.
        outputs: userdata key -> field of the result.
        timeout_s: [s] default of the goal's timeout.
    """

    outcome: str
    means: str
    inputs: tuple[Field, ...]
    parameters: tuple[Parameter, ...]
    outputs: Mapping[str, Field]
    timeout_s: float


@dataclass(frozen=True)
class Ability:
    """A row.

    Attributes:
        package: whose action and table it is.
        errors: names of the codes that it reports, besides those of the contract.
        state: None if there is none, or it is written by hand.
        colour: in reports, such as "#219ebc"; empty for the usual one.
        fake: fields of the result that a fake server returns.
    """

    package: str
    action: Action
    errors: tuple[str, ...]
    state: AbilityState | None = None
    colour: str = ""
    fake: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of its action, such as "InsertCable"."""
        return self.action.name

    @property
    def topic(self) -> str:
        """The action's usual topic, as Deliverable 5.1 writes it: lower case, without gaps."""
        return f"remodel_abilities/{self.name.lower()}"


def abilities_from(
    package: str, table: Mapping[str, Any], actions: Mapping[str, Action], codes: Collection[str]
) -> tuple[dict[str, Ability], list[str]]:
    """Return the abilities of a package by name, and what contradicts itself in its table.

    Args:
        package: its name.
        table: in the form of the schema.
        actions: those of the package, by name.
        codes: names of all error codes.
    """
    found, problems = {}, []
    for name, row in table["abilities"].items():
        if name not in actions:
            names = ", ".join(actions) or "none"
            problems.append(f"abilities.{name}: no action/{name}.action; there are: {names}")
            continue
        mistakes = [*_mistakes(row, actions[name], codes)]
        problems += [f"abilities.{name}.{mistake}" for mistake in mistakes]
        if not mistakes:
            found[name] = _ability(package, row, actions[name])
    return found, problems


def _ability(package: str, row: Mapping[str, Any], action: Action) -> Ability:
    state = _state(row["state"], action) if "state" in row else None
    errors = tuple(row["errors"])
    return Ability(
        package, action, errors, state, colour=row.get("colour", ""), fake=row.get("fake", {})
    )


def _state(row: Mapping[str, Any], action: Action) -> AbilityState:
    goal, result = _by_name(action.goal), _by_name(action.result)
    given = _parameter_fields(row)
    parameters = [Parameter(name, goal[f], default) for name, (f, default) in given.items()]
    return AbilityState(
        row["outcome"],
        row["means"],
        tuple(goal[name] for name in row.get("inputs", [])),
        tuple(sorted(parameters, key=lambda parameter: not parameter.is_required)),
        outputs={key: result[name] for key, name in row.get("outputs", {}).items()},
        timeout_s=float(row["timeout_s"]),
    )


def _by_name(fields: tuple[Field, ...]) -> dict[str, Field]:
    return {item.name: item for item in fields}


def _parameter_fields(row: Mapping[str, Any]) -> dict[str, tuple[str, Any]]:
    """Return parameter -> (field of the goal, default) of a state's row."""
    return {
        name: (value["field"], value.get("default")) if isinstance(value, dict) else (name, value)
        for name, value in row.get("parameters", {}).items()
    }


def _mistakes(row: Mapping[str, Any], action: Action, codes: Collection[str]) -> Iterator[str]:
    results = [item.name for item in action.result if item.name not in COMMON_RESULT]
    for name in row["errors"]:
        if name not in codes:
            yield f"errors: {name} is not an error code; list it in a faults.yaml"
    yield from _unknown("fake", row.get("fake", {}), results, "result")
    if "state" in row:
        yield from _state_mistakes(row["state"], action, results)


def _state_mistakes(row: Mapping[str, Any], action: Action, results: list[str]) -> Iterator[str]:
    goal = {item.name: item for item in action.goal if item.name not in COMMON_GOAL}
    given = [name for name, _ in _parameter_fields(row).values()]
    yield from _unknown("state.inputs", row.get("inputs", []), goal, "goal")
    yield from _unknown("state.parameters", given, goal, "goal")
    yield from _unknown("state.outputs", row.get("outputs", {}).values(), results, "result")
    yield from _unusable("parameters", _parameter_fields(row), _PARAMETERS_TAKEN)
    yield from _unusable("outputs", row.get("outputs", {}), _OUTPUTS_TAKEN)
    used = [*row.get("inputs", []), *given]
    for name in goal:
        if (times := used.count(name)) != 1:
            yield f"state: field {name} of the goal is given {times} times; allowed: once"
    for name in given:
        if name in goal and goal[name].type not in (*PLAIN_TYPES, POSE, POSES):
            types = ", ".join((*PLAIN_TYPES, POSE, POSES))
            yield f"state.parameters: {name} is of type {goal[name].type}; allowed: {types}"
    for name, (field_name, default) in _parameter_fields(row).items():
        kind = goal[field_name].type if field_name in goal else ""
        if default is not None and kind in _DEFAULTS and type(default) not in _DEFAULTS[kind]:
            yield (
                f"state.parameters: the default of {name} is {default!r}; allowed: a value of type "
                f"{PLAIN_TYPES[kind]}"
            )


def _unusable(place: str, names: Iterable[str], taken: Collection[str]) -> Iterator[str]:
    """Yield what is wrong with names that the source of a state is to have."""
    for name in names:
        if not str(name).isidentifier() or keyword.iskeyword(name) or name in taken:
            yield (
                f"state.{place}: {name} cannot be a name in the state's source; allowed: Python "
                f"names but {', '.join(taken)}"
            )


def _unknown(
    place: str, names: Collection[str], known: Collection[str], part: str
) -> Iterator[str]:
    for name in names:
        if name not in known:
            yield f"{place}: {name} is not a field of the {part}; there are: {', '.join(known)}"


# Read action files: the fields of goal and result, with their comments


_FIELD = re.compile(r"^(?P<type>[^\s#]\S*)\s+(?P<name>[a-zA-Z]\w*)\s*(?:#\s*(?P<text>.*))?$")

# Fields that every goal and every result has (Deliverable 5.1, 3.1).
COMMON_GOAL = ("id", "timeout")
COMMON_RESULT = ("id", "success", "message", "elapsed_time", "error_code", "error_message")


@dataclass(frozen=True)
class Field:
    """A field of a message; `type` is that of the ROS message, `text` its comment."""

    name: str
    type: str
    text: str


@dataclass(frozen=True)
class Action:
    """An action.

    Attributes:
        title: what it does: the first comment of its file, without the name.
        goal: fields, those of all goals included.
        result: fields, those of all results included.
    """

    name: str
    title: str
    goal: tuple[Field, ...]
    result: tuple[Field, ...]


def action_from(name: str, text: str) -> Action:
    """Return the action of a file's text."""
    goal, result, *_ = (*text.split("\n---"), "")
    title = next((line.lstrip("# ") for line in goal.splitlines() if line.startswith("#")), "")
    return Action(name, title.removeprefix(f"{name}: "), _fields(goal), _fields(result))


def _fields(text: str) -> tuple[Field, ...]:
    found = filter(None, (_FIELD.match(line.strip()) for line in text.splitlines()))
    return tuple(Field(m["name"], m["type"], (m["text"] or "").strip()) for m in found)


# Which abilities a node serves, of those that there are


def chosen_abilities(
    known: Collection[str], abilities: object = "", others: object = ""
) -> list[str]:
    """Return the abilities to serve, in the order of `known`.

    Args:
        known: names of all abilities.
        abilities: those to serve, a list or text such as "InsertCable, PickCable"; empty text: all,
            empty list: none.
        others: those of them not to serve, in the same form.

    Raises:
        ValueError: if a name is none of `known`.
    """
    wanted = list(known) if abilities == "" else _names("abilities", abilities, known)
    without = _names("except", others, known)
    return [name for name in known if name in wanted and name not in without]


def _names(parameter: str, value: object, known: Collection[str]) -> list[str]:
    if isinstance(value, str):
        names = [name.strip() for name in value.split(",") if name.strip()]
    elif isinstance(value, list | tuple):
        names = [str(name) for name in value]
    else:
        raise ValueError(
            f"parameter {parameter!r} is {value!r}; allowed: names of abilities, "
            "separated by commas"
        )
    if unknown := sorted(set(names) - set(known)):
        raise ValueError(
            f"parameter {parameter!r} names no ability: {', '.join(unknown)}; "
            f"there are {', '.join(known)}"
        )
    return names
