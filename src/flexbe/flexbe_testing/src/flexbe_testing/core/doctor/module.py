"""What the doctor examines, a file and its classes, and what it finds there."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import TypeGuard


class Severity(Enum):
    """How much a finding matters."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One place in a user's file.

    Attributes:
        file: the file.
        line: the line, from 1 on.
        rule: short name of what was found.
        severity: error if it does not work on this engine, warning if it works differently, note if
            it works but could work better.
        text: what was found, and what to do.
    """

    file: str
    line: int
    rule: str
    severity: Severity
    text: str

    @property
    def is_bad(self) -> bool:
        """Whether the finding is more than a note."""
        return self.severity is not Severity.NOTE


@dataclass(frozen=True)
class Report:
    """What was found in a workspace.

    Attributes:
        findings: all findings.
        packages: names of the packages that were examined.
        states: number of state classes.
        behaviors: number of behavior classes.
        constructed: number of states and behaviors that were constructed.
    """

    findings: tuple[Finding, ...]
    packages: tuple[str, ...]
    states: int
    behaviors: int
    constructed: int

    def as_text(self, folder: str) -> str:
        """Return one line for each finding, with files relative to a folder, and a summary."""
        lines = [
            f"{_relative(f.file, folder)}:{f.line}: {f.severity.value} [{f.rule}] {f.text}"
            for f in self.findings
        ]
        counts = ", ".join(f"{self.count(severity)} {severity.value}s" for severity in Severity)
        return "\n".join(
            [
                *lines,
                f"{len(self.packages)} packages, {self.states} states, {self.behaviors} behaviors; "
                f"{self.constructed} constructed: {counts}",
            ]
        )

    def as_dict(self) -> dict[str, object]:
        """Return the report for JSON."""
        findings = [{**asdict(f), "severity": f.severity.value} for f in self.findings]
        return {**asdict(self), "findings": findings}

    def count(self, severity: Severity) -> int:
        """Return how many findings have a severity."""
        return sum(finding.severity is severity for finding in self.findings)


def sorted_findings(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings by file and line, each once."""
    unique = set(findings)
    return tuple(sorted(unique, key=lambda f: (f.file, f.line, f.rule, f.text)))


def _relative(file: str, folder: str) -> str:
    return file.removeprefix(f"{folder.rstrip('/')}/")


# A user's module, parsed: its FlexBE classes and their methods


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
