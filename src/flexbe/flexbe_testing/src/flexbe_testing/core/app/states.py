"""How the App reads a state, and what it does not see of a state class."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from flexbe_testing.core.app import text as cut

_CLASS = re.compile(r"^\s*class\s+(\w+)\s*\(EventState\)\s*:", re.MULTILINE)
_PARAMETERS = re.compile(r"\bdef __init__\(self, ([^)\n]+)\):")
_LISTS = ("outcomes", "input_keys", "output_keys")


@dataclass(frozen=True)
class FromParameter:
    """A list of names that comes from the value of a parameter; a `?` begins an artificial one."""

    parameter: str


Names = tuple[str, ...] | FromParameter


@dataclass(frozen=True)
class StateDefinition:
    """What the App knows of a state class.

    Attributes:
        module: where behaviors import it from.
        parameters: default of each parameter as text; None if it has none.
        outcomes: without blanks, which the App drops.
        spellings: each outcome as the file spells it, by the App's name of it.
    """

    class_name: str
    package: str
    module: str
    parameters: dict[str, str | None]
    outcomes: Names = ()
    input_keys: Names = ()
    output_keys: Names = ()
    spellings: dict[str, str] = field(default_factory=dict)


def read_state(text: str, module: str) -> StateDefinition | None:
    """Return the first state of a file, None if the App sees none."""
    found = _CLASS.search(text)
    if found is None:
        return None
    body = text[found.end() :]
    given = _PARAMETERS.search(body)
    parameters = dict(map(_parameter, cut.items(given[1]))) if given else {}
    lists: dict[str, Names] = {}
    spellings: dict[str, str] = {}
    for keyword, value in _super_arguments(body).items():
        if keyword in _LISTS:
            lists[keyword] = _names(keyword, value, parameters)
            if keyword == "outcomes":
                spellings = {without_blanks(name): name for name in cut.names(value) or ()}
    parameters |= {
        listed.parameter: None
        for listed in lists.values()
        if isinstance(listed, FromParameter) and listed.parameter not in parameters
    }
    package = module.partition(".")[0]
    return StateDefinition(found[1], package, module, parameters, spellings=spellings, **lists)


def without_blanks(outcome: str) -> str:
    """Return an outcome as the App reads it from a list of outcomes."""
    return re.sub(r"\s", "", outcome)


def _parameter(text: str) -> tuple[str, str | None]:
    """Return name and default; an annotation counts as part of the name, as in the App."""
    name, equals, default = text.partition("=")
    return name.strip(), re.sub(r"\s", "", default) if equals else None


def _super_arguments(body: str) -> dict[str, str]:
    call = re.search(r"\bsuper\([^)]*\)\.__init__\(", body)
    inner = call and cut.bracketed(body, call.end() - 1)
    return dict(_keyword(item) for item in cut.items(inner or "") if "=" in item)


def _keyword(item: str) -> tuple[str, str]:
    name, _, value = item.partition("=")
    return name.strip(), value.strip()


def _names(keyword: str, value: str, parameters: dict[str, str | None]) -> Names:
    listed = cut.names(value)
    if listed is not None:
        return tuple(without_blanks(n) if keyword == "outcomes" else n for n in listed)
    return FromParameter(value if value in parameters else f"?{keyword}")


# Whether the App sees all of a state class


_BASE = "EventState"


def judge_state(text: str, module: str) -> list[str]:
    """Return what the App does not see of the states in a file, each with its line.

    Args:
        text: the file.
        module: where behaviors import it from.

    Raises:
        SyntaxError: if it is not Python.
    """
    seen = read_state(text, module)
    states = [
        node
        for node in ast.parse(text).body
        if isinstance(node, ast.ClassDef) and _BASE in map(ast.unparse, node.bases)
    ]
    return [
        f"line {line}: the App {what}" for state in states for line, what in _hidden(state, seen)
    ]


def _hidden(state: ast.ClassDef, seen: StateDefinition | None) -> Iterator[tuple[int, str]]:
    """Yield line and text of each part that the App does not see."""
    if seen is None or seen.class_name != state.name:
        why = f"is not the first class of its file with the base list ({_BASE})"
        yield state.lineno, f"does not see {state.name}, which {why}"
        return
    init = next((n for n in state.body if getattr(n, "name", "") == "__init__"), None)
    if not isinstance(init, ast.FunctionDef):
        yield state.lineno, f"sees no outcome of {state.name}, which has no __init__"
        return
    arguments = [a.arg for a in (*init.args.posonlyargs, *init.args.args, *init.args.kwonlyargs)]
    hidden = [name for name in arguments[1:] if name not in seen.parameters]
    if hidden:
        yield (
            init.lineno,
            f"does not see the arguments {', '.join(hidden)} of {state.name}: all must follow "
            "'def __init__(self, ' on one line, without annotations and inner ')'",
        )
    for name in seen.parameters:
        if name.startswith("?"):
            yield (
                init.lineno,
                f"cannot read the {name[1:]} of {state.name}: they are not a plain list",
            )
    if not seen.outcomes:
        yield init.lineno, f"sees no outcome of {state.name}"
    if any(isinstance(node, ast.keyword) and node.arg == "io_keys" for node in ast.walk(init)):
        yield init.lineno, f"does not see io_keys of {state.name}: list them as input and output"
    for name in () if isinstance(seen.outcomes, FromParameter) else seen.outcomes:
        if seen.spellings.get(name, name) != name:
            yield (
                init.lineno,
                f"reads outcome '{seen.spellings[name]}' of {state.name} as '{name}'",
            )
