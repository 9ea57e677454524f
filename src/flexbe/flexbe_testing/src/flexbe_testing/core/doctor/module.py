"""A user's module, parsed: its FlexBE classes and their methods."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeGuard

from flexbe_testing.core.doctor.finding import Finding, Severity

_STATES = {"State", "RosState", "ManuallyTransitionableState", "LockableState"}
_STATES |= {"PreemptableState", "OperatableState", "EventState"}
_MACHINES = {"StateMachine", "RosStateMachine", "LockableStateMachine", "PreemptableStateMachine"}
_MACHINES |= {"OperatableStateMachine", "ConcurrencyContainer", "PriorityContainer"}


class Kind(Enum):
    """What a class is for FlexBE."""

    STATE = "state"
    MACHINE = "container"
    BEHAVIOR = "behavior"


@dataclass
class FlexbeClass:
    """A class that derives from one of FlexBE's.

    Attributes:
        kind: what it is.
        node: its definition.
        methods: its methods, by name.
    """

    kind: Kind
    node: ast.ClassDef
    methods: dict[str, ast.FunctionDef] = field(default_factory=dict)

    def reached(self, names: tuple[str, ...]) -> Iterator[ast.FunctionDef]:
        """Yield methods, and those of the class that they call on self, each once."""
        waiting, seen = list(names), set()
        while waiting:
            name = waiting.pop()
            if name in seen or name not in self.methods:
                continue
            seen.add(name)
            yield self.methods[name]
            for node in ast.walk(self.methods[name]):
                if isinstance(node, ast.Call) and is_self_attribute(node.func):
                    waiting.append(node.func.attr)


@dataclass
class Module:
    """A parsed file.

    Attributes:
        file: its path.
        text: its source.
        tree: its syntax tree.
        names: what imported names stand for: local name -> dotted name.
        classes: its FlexBE classes.
    """

    file: str
    text: str
    tree: ast.Module
    names: dict[str, str]
    classes: list[FlexbeClass]

    def finding(self, node: ast.AST | int, rule: str, severity: Severity, text: str) -> Finding:
        """Return a finding at a node or line."""
        line = node if isinstance(node, int) else getattr(node, "lineno", 1)
        return Finding(self.file, line, rule, severity, text=text)

    def dotted(self, node: ast.AST) -> str:
        """Return what an expression of names and attributes stands for; empty if it is another."""
        if isinstance(node, ast.Name):
            return self.names.get(node.id, node.id)
        if isinstance(node, ast.Attribute):
            value = self.dotted(node.value)
            return f"{value}.{node.attr}" if value else ""
        return ""


def parse_module(file: str, text: str) -> Module:
    """Parse a file.

    Raises:
        SyntaxError: if it is not Python 3.
    """
    tree = ast.parse(text, file)
    module = Module(file, text, tree, _imported(tree), classes=[])
    kinds: dict[str, Kind] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and (kind := _kind(module, node, kinds)):
            kinds[node.name] = kind
            methods = {item.name: item for item in node.body if isinstance(item, ast.FunctionDef)}
            module.classes.append(FlexbeClass(kind, node, methods))
    return module


def is_self_attribute(node: ast.AST) -> TypeGuard[ast.Attribute]:
    """Return whether an expression is `self.something`."""
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "self"
    )


def _imported(tree: ast.Module) -> dict[str, str]:
    names: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                top = alias.name if alias.asname else alias.name.split(".")[0]
                names[alias.asname or top] = top
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                names[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    return names


def _kind(module: Module, node: ast.ClassDef, known: dict[str, Kind]) -> Kind | None:
    for base in node.bases:
        name = module.dotted(base)
        last = name.rpartition(".")[2]
        if name in known:
            return known[name]
        if name.startswith("flexbe_core"):
            if last in _STATES:
                return Kind.STATE
            if last in _MACHINES:
                return Kind.MACHINE
            if last == "Behavior":
                return Kind.BEHAVIOR
        elif last.endswith("State") and "." in name and not name.startswith("smach"):
            return Kind.STATE  # a user's own base, in another module
    return None
