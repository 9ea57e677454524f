"""What is left of Python 2."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from flexbe_testing.core.doctor.finding import Finding, Severity
from flexbe_testing.core.doctor.module import Module

_METHODS = {"iteritems": "items", "iterkeys": "keys", "itervalues": "values", "has_key": "in"}
_NAMES = {
    **{"xrange": "range", "unicode": "str", "basestring": "str", "raw_input": "input"},
    **{"unichr": "chr", "long": "int", "reduce": "functools.reduce", "execfile": "exec"},
}
_MODULES = {
    **{"Queue": "queue", "ConfigParser": "configparser", "cPickle": "pickle"},
    **{"StringIO": "io", "cStringIO": "io", "urllib2": "urllib.request", "thread": "_thread"},
    **{"commands": "subprocess", "Tkinter": "tkinter", "__builtin__": "builtins"},
}

# Statements that Python 3 does not parse.
_STATEMENTS = (
    (re.compile(r"^\s*print\s+[^\s(=]"), "the print statement; write print(...)"),
    (re.compile(r"^\s*except\s+[\w.]+\s*,\s*\w+\s*:"), "except X, e; write except X as e"),
    (re.compile(r"^\s*raise\s+[\w.]+\s*,"), "raise X, text; write raise X(text)"),
    (re.compile(r"^\s*exec\s+[\"'\w]"), "the exec statement; write exec(...)"),
    (re.compile(r"<>"), "the operator <>; write !="),
    (re.compile(r"\b0\d+\b"), "an octal number without o; write 0o..."),
)


def unparsable(file: str, text: str, error: SyntaxError) -> Finding:
    """Return the finding for a file that is not Python 3."""
    line = error.lineno or 1
    lines = text.splitlines()
    source = lines[line - 1] if 0 < line <= len(lines) else ""
    for pattern, what in _STATEMENTS:
        if pattern.search(source):
            return Finding(file, line, "python2", Severity.ERROR, text=f"Python 2: {what}")
    text = f"the file is not Python 3: {error.msg}"
    return Finding(file, line, "syntax", Severity.ERROR, text=text)


def check_python2(module: Module) -> Iterator[Finding]:
    """Find names that Python 3 does not have."""
    own, guarded = _defined(module.tree), _guarded(module.tree)
    for node in ast.walk(module.tree):
        text = ""
        if isinstance(node, ast.Attribute) and node.attr in _METHODS:
            text = f".{node.attr}() is gone; use {_METHODS[node.attr]}"
        elif isinstance(node, ast.Name) and node.id in _NAMES and node.id not in own:
            text = f"{node.id} is gone; use {_NAMES[node.id]}"
        elif isinstance(node, ast.Import | ast.ImportFrom) and node not in guarded:
            names = [alias.name for alias in node.names]
            top = (node.module or "") if isinstance(node, ast.ImportFrom) else names[0]
            if top in _MODULES:
                text = f"the module {top} is gone; use {_MODULES[top]}"
        if text:
            yield module.finding(node, "python2", Severity.ERROR, f"Python 2: {text}")


def _defined(tree: ast.Module) -> set[str]:
    """Return the names that a file binds itself."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
    return names


def _guarded(tree: ast.Module) -> set[ast.AST]:
    """Return what stands in a try statement, where an import may fail."""
    tries = [node for node in ast.walk(tree) if isinstance(node, ast.Try)]
    return {node for item in tries for node in ast.walk(item)}
