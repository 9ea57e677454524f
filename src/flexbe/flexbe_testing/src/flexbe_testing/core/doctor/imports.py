"""Imports of what this engine does not have."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from difflib import get_close_matches

from flexbe_testing.core.doctor.finding import Finding, Severity
from flexbe_testing.core.doctor.module import Module

# Returns the public names of a module of flexbe_core; None if there is no such module.
Surface = Callable[[str], frozenset[str] | None]


def check_imports(module: Module, surface: Surface) -> Iterator[Finding]:
    """Find imports from flexbe_core that fail here."""
    for node in ast.walk(module.tree):
        if isinstance(node, ast.ImportFrom) and _is_flexbe(node.module):
            yield from _check_from(module, node, surface)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if _is_flexbe(alias.name) and surface(alias.name) is None:
                    yield _missing_module(module, node, alias.name)


def _check_from(module: Module, node: ast.ImportFrom, surface: Surface) -> Iterator[Finding]:
    name = node.module or ""
    known = surface(name)
    if known is None:
        yield _missing_module(module, node, name)
        return
    for alias in node.names:
        if alias.name == "*" or alias.name in known or surface(f"{name}.{alias.name}") is not None:
            continue
        near = get_close_matches(alias.name, known, n=2)
        hint = f"; near it: {', '.join(near)}" if near else ""
        text = f"{name} has no {alias.name!r} on this engine{hint}"
        yield module.finding(node, "unknown-import", Severity.ERROR, text)


def _missing_module(module: Module, node: ast.AST, name: str) -> Finding:
    text = f"there is no module {name} on this engine; import from flexbe_core or flexbe_core.proxy"
    return module.finding(node, "unknown-import", Severity.ERROR, text)


def _is_flexbe(name: str | None) -> bool:
    return (name or "").split(".")[0] == "flexbe_core"
