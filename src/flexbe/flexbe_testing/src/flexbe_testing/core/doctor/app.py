"""What the FlexBE App cannot read: it parses files as text."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from flexbe_testing.core.doctor.finding import Finding, Severity
from flexbe_testing.core.doctor.module import FlexbeClass, Kind, Module

_RULE = "app"
_INIT = re.compile(r"def __init__\(self(?P<rest>[^\n]*)")


def check_app(module: Module) -> Iterator[Finding]:
    """Find what the App does not see, or refuses, in states and behaviors."""
    for found in module.classes:
        bases = [ast.unparse(base) for base in found.node.bases]
        if found.kind is Kind.STATE and bases == ["EventState"]:
            yield from _check_state(module, found)
        elif found.kind is Kind.BEHAVIOR:
            yield from _check_behavior(module, found, bases)


def _check_state(module: Module, found: FlexbeClass) -> Iterator[Finding]:
    init = found.methods.get("__init__")
    if init is not None:
        yield from _check_signature(module, init)
    for node in ast.walk(found.node):
        if isinstance(node, ast.keyword) and node.arg == "outcomes":
            for item in getattr(node.value, "elts", []):
                if isinstance(item, ast.Constant) and " " in str(item.value):
                    text = f"outcome {item.value!r}: the App drops the blank, and its transition"
                    yield module.finding(item, _RULE, Severity.NOTE, text)


def _check_signature(module: Module, init: ast.FunctionDef) -> Iterator[Finding]:
    """The parameters begin on the line of `def __init__(self, `, and hold no bracket or type."""
    arguments = [*init.args.args[1:], *init.args.kwonlyargs]
    if not arguments:
        return
    line = module.text.splitlines()[init.lineno - 1]
    if not re.search(r"def __init__\(self, ", line):
        text = "the parameters do not begin on the line of `def __init__(self, `: the App sees none"
        yield module.finding(init, _RULE, Severity.WARNING, text)
    defaults = [item for item in (*init.args.defaults, *init.args.kw_defaults) if item is not None]
    for item in defaults:
        if ")" in (ast.get_source_segment(module.text, item) or ""):
            text = "a default with `)`: the App reads the parameters up to there only"
            yield module.finding(item, _RULE, Severity.WARNING, text)
    for argument in arguments:
        if argument.annotation is not None:
            text = f"the App takes the type of {argument.arg!r} for part of its name"
            yield module.finding(argument, _RULE, Severity.WARNING, text)


def _check_behavior(module: Module, found: FlexbeClass, bases: list[str]) -> Iterator[Finding]:
    if bases != ["Behavior"]:
        text = f"the bases are ({', '.join(bases)}): the App loads only (Behavior)"
        yield module.finding(found.node, _RULE, Severity.WARNING, text)
    for name in ("__init__", "create"):
        method = found.methods.get(name)
        line = "" if method is None else module.text.splitlines()[method.lineno - 1].strip()
        if method is not None and line != f"def {name}(self):":
            text = f"the App loads only `def {name}(self):`, found `{line}`"
            yield module.finding(method, _RULE, Severity.WARNING, text)
