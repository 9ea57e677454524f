"""Whether the App sees all of a state class."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from flexbe_testing.app.states import FromParameter, StateDefinition, read_state

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
