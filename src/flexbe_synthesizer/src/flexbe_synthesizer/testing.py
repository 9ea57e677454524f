"""For tests: whether the FlexBE App can read a behavior's file back.

The App reads behaviors by their text, not as Python, so a file that runs may still be unreadable to
it. `app_complaints` holds a file to the rules of that reader and to what the App demands of a
behavior before it saves it.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass

_IMPORT = re.compile(r"^from [\w.]+ import (\w+(, \w+)*)( as \w+)?$")
_POSITION = re.compile(r"^\s*# x:-?\d+ y:-?\d+(, x:-?\d+ y:-?\d+)*$")
_SECTION_END = re.compile(r"\sdef\s")
_PLAIN_CONTAINER = re.compile(r"(\w+) = (?:OperatableStateMachine|PriorityContainer)\(([^)]*)\)\n")
_CONCURRENCY = re.compile(
    r"(\w+) = ConcurrencyContainer\((.*?)conditions=\[\n(.*?)\n\s+\]\)\n", re.S
)
_CONDITION = re.compile(r"\s*\('[^']+', \[\('[^']+', '[^']+'\)(, \('[^']+', '[^']+'\))*\]\),?\s*")
_AUTONOMY = ("Autonomy.Off", "Autonomy.Low", "Autonomy.High", "Autonomy.Full", "Autonomy.Inherit")


def app_complaints(text: str) -> list[str]:
    """Return what keeps the FlexBE App from reading or saving the behavior; none is good."""
    return [*_file_complaints(text), *_create_complaints(text)]


def _without_manual(text: str) -> str:
    for tag in ("IMPORT", "INIT", "CREATE", "FUNC"):
        text = re.sub(rf"(# \[MANUAL_{tag}\]).*?(# \[/MANUAL_{tag}\])", r"\1\2", text, flags=re.S)
    return text


def _section(text: str, head: str) -> str:
    """Return a method's text as the App cuts it out: up to the next ` def `."""
    rest = text.partition(head)[2]
    end = _SECTION_END.search(rest)
    return rest[: end.start()] if end else rest


def _file_complaints(text: str) -> Iterator[str]:
    """Yield what is wrong outside of `create`."""
    if "\r" in text:
        yield "line ends other than LF"
    for tag in ("IMPORT", "INIT", "CREATE", "FUNC"):
        tags = re.findall(rf"# \[/?MANUAL_{tag}\]", text)
        if tags != [f"# [MANUAL_{tag}]", f"# [/MANUAL_{tag}]"]:
            yield f"the tags of MANUAL_{tag} are {tags}"
    read = _without_manual(text)
    if re.findall(r"^\s*class\s+\w+\s*\((.*)\):", read, flags=re.M) != ["Behavior"]:
        yield "not exactly one class with the base list (Behavior)"
    if not re.search(r"\n'''\nCreated on [^'\n]+\n@author: [^'\n]+\n'''\nclass ", read):
        yield "no block with date and author before the class"
    if not re.search(r"\):\n\s+'''\n[^']*\n\s+'''\n", read):
        yield "no docstring in triple single quotes, free of apostrophes"
    for head in ("def __init__(self):", "def create(self):"):
        if read.count(head) != 1:
            yield f"not exactly one {head}"
    if not re.search(r"^\s+self\.name = '[^'\"]+'$", _section(read, "def __init__(self):"), re.M):
        yield "no plain self.name"
    if "# Behavior comments:" not in _section(read, "def __init__(self):"):
        yield "__init__ ends early for the App: ' def ' stands in it"
    for line in read.splitlines():
        if re.match(r"\s*(from|import)\s", line) and not _IMPORT.match(line):
            yield f"an import that is not read: {line}"


@dataclass(frozen=True)
class _Container:
    """What the App makes of a container's definition."""

    kind: str
    outcomes: tuple[str, ...]
    keys: tuple[str, ...]
    conditions: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()


def _create_complaints(text: str) -> Iterator[str]:
    """Yield what is wrong in `create`."""
    section = _section(_without_manual(text), "def create(self):")
    returned = re.search(r"^\s+return (\w+)$", section, re.M)
    if returned is None:
        yield "create does not return a variable, or ends early for the App: ' def ' stands in it"
        return
    textual = list(_textual_complaints(section))
    yield from textual
    if textual:
        return
    body = _create_body(text)
    containers = {
        node.targets[0].id: _container(node.value)
        for node in body
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and isinstance(node.value, ast.Call)
    }
    userdata = re.findall(r"^\s+\w+\.userdata\.(\w+) = \S", section, re.M)
    missing = set(containers[returned[1]].keys) - set(userdata)
    if missing:
        yield f"no default userdata for {sorted(missing)}"
    filled = set()
    for node in body:
        if isinstance(node, ast.With):
            name = ast.unparse(node.items[0].context_expr)
            filled.add(name)
            yield from _container_complaints(name, containers[name], node)
            yield from _parameter_complaints(text, node)
    for name in containers.keys() - filled:
        yield f"{name} has no states"


def _create_body(text: str) -> list[ast.stmt]:
    found = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.FunctionDef)]
    return next(function.body for function in found if function.name == "create")


def _textual_complaints(section: str) -> Iterator[str]:
    """Yield definitions and comments in a form that the App does not read."""
    definitions = re.findall(r"^\s+(\w+) = (\w+)\(", section, re.M)
    read = {name for name, _arguments in _PLAIN_CONTAINER.findall(section)}
    for name, arguments in _PLAIN_CONTAINER.findall(section):
        if not re.fullmatch(r"(\w+=\[[^\]]*\](, )?)+", arguments):
            yield f"{name} has other than keyword arguments that are lists"
    for name, _lists, conditions in _CONCURRENCY.findall(section):
        read.add(name)
        for line in conditions.splitlines():
            if not _CONDITION.fullmatch(line):
                yield f"{name} has a condition that is not read: {line.strip()}"
    for name, kind in definitions:
        if name not in read:
            yield f"{name} = {kind}(...) is not read as a container"
    lines = section.splitlines()
    for above, line in itertools.pairwise(lines):
        is_placed = ".add(" in line or re.match(r"\s+_\w+ = \w+\(", line)
        if is_placed and not _POSITION.match(above):
            yield f"no position above: {line.strip()}"
        variable = re.match(r"\s+(\w+) = ", line)
        if variable and variable[1] not in read:
            yield f"a private variable: {line.strip()}"


def _container(call: ast.Call) -> _Container:
    given = {keyword.arg: ast.literal_eval(keyword.value) for keyword in call.keywords}
    keys = (*given.get("input_keys", ()), *given.get("output_keys", ()))
    conditions = tuple((outcome, tuple(pairs)) for outcome, pairs in given.get("conditions", ()))
    return _Container(ast.unparse(call.func), tuple(given["outcomes"]), keys, conditions)


def _container_complaints(name: str, container: _Container, block: ast.With) -> Iterator[str]:
    """Yield what the App would not accept of a container's content."""
    calls = [node.value for node in block.body if isinstance(node, ast.Expr)]
    added = [c for c in calls if isinstance(c, ast.Call)]
    if not added or any(ast.unparse(c.func) != "OperatableStateMachine.add" for c in added):
        yield f"{name} holds other than OperatableStateMachine.add"
        return
    if not container.outcomes:
        yield f"{name} has no outcomes"
    labels = [ast.literal_eval(call.args[0]) for call in added]
    if len(set(labels)) < len(labels) or set(labels) & set(container.outcomes):
        yield f"{name} has a label twice, or one that is its outcome"
    pairs = [pair for _outcome, condition in container.conditions for pair in condition]
    if len(set(pairs)) < len(pairs):
        yield f"{name} uses an outcome of a state in two conditions"
    for label, call in zip(labels, added, strict=True):
        for complaint in _state_complaints(call, {*labels, *container.outcomes}):
            yield f"{name}/{label} {complaint}"
        given = {k.arg: k.value for k in call.keywords}
        if container.kind == "ConcurrencyContainer":
            for outcome, target in ast.literal_eval(given["transitions"]).items():
                causes = [
                    o for o, condition in container.conditions if (label, outcome) in condition
                ]
                if causes != [target]:
                    yield f"{name}/{label} leads '{outcome}' to '{target}', its condition {causes}"


def _state_complaints(call: ast.Call, targets: set[str]) -> Iterator[str]:
    """Yield what the App would not accept of one state."""
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    if not {"transitions", "autonomy"} <= given.keys() <= {"transitions", "autonomy", "remapping"}:
        yield f"is added with {sorted(map(str, given))}"
        return
    transitions = ast.literal_eval(given["transitions"])
    autonomy = ast.unparse(given["autonomy"]).strip("{}").split(", ")
    levels = dict(item.replace("'", "").split(": ") for item in autonomy)
    if list(levels) != list(transitions) or not set(levels.values()) <= set(_AUTONOMY):
        yield f"has transitions {transitions} and autonomy {levels}"
    for target in transitions.values():
        if target not in targets:
            yield f"leads to '{target}', which is not there"
    remapping = ast.literal_eval(given.get("remapping", ast.Dict([], [])))
    for key in (*remapping, *remapping.values()):
        if not key.isidentifier():
            yield f"maps the key '{key}', which is no identifier"


def _parameter_complaints(text: str, block: ast.With) -> Iterator[str]:
    """Yield parameters of behaviors that the App cannot read: no brackets may close in them."""
    for node in ast.walk(block):
        if isinstance(node, ast.keyword) and node.arg == "parameters":
            source = ast.get_source_segment(text, node.value) or ""
            if re.search(r"[{})]", source[1:-1]):
                yield f"parameters that cannot be read: {source}"
