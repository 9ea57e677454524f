"""The rules on source text, but for what blocks the engine."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches

from flexbe_testing.core.app_behavior import AppLoadError, Known, judge_state
from flexbe_testing.core.app_load import load_behavior
from flexbe_testing.core.doctor_module import (
    Finding,
    FlexbeClass,
    Kind,
    Module,
    Severity,
    check_blocking,
    is_self_attribute,
    parse_module,
)


@dataclass(frozen=True)
class Engine:
    """What users' code can use of this engine.

    Attributes:
        surface: the names of each module of flexbe_core.
        attributes: the names that states and containers have.
    """

    surface: Surface
    attributes: frozenset[str]


def examine(
    file: str, text: str, engine: Engine, known: Known
) -> tuple[list[Finding], Module | None]:
    """Return the findings in a file, and the parsed file if it is Python 3.

    Args:
        file: its path.
        text: its source.
        engine: what this engine has.
        known: the states and behaviors that the FlexBE App would find.
    """
    try:
        module = parse_module(file, text)
    except SyntaxError as error:
        return [unparsable(file, text, error)], None
    found = [*check_imports(module, engine.surface), *check_python2(module)]
    found += [*check_blocking(module), *check_internals(module, engine.attributes)]
    return [*found, *check_app(module, known)], module


def count(module: Module, kind: Kind) -> int:
    """Return how many classes of a kind a file has."""
    return sum(found.kind is kind for found in module.classes)


# Imports of what this engine does not have


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


# Uses of an engine's inside, which is another one here


# Attributes of stock FlexBE's states and containers that users may have come to rely on.
_OF_BOTH = {"_force_transition", "_stored_outcome", "_last_requested_outcome", "_entering"}
_OF_BOTH |= {"_skipped", "_paused", "_last_active_container", "_preempted_name", "_locked"}
_OF_BOTH |= {"_is_controlled"}
_OF_CONTAINERS = {"_inner_sync_request", "_last_exception", "_current_state", "_userdata"}
_OF_CONTAINERS |= {"_own_userdata", "_labels", "_states", "_transitions", "_remappings"}
_OF_CONTAINERS |= {"_autonomy", "_returned_outcomes"}
_PRIVATE = {Kind.STATE: _OF_BOTH, Kind.MACHINE: _OF_BOTH | _OF_CONTAINERS, Kind.BEHAVIOR: set()}
_TOPICS = {
    f"_{name}_topic"
    for name in (
        *("feedback", "transition", "lock", "unlock", "preempt", "outcome", "request"),
        *("debug", "repeat", "pause"),
    )
}

# Methods that stock FlexBE calls in a run and this engine does not: an override has no effect.
OVERRIDES = {
    Kind.STATE: {"sleep", "is_locked", "_notify_skipped"},
    Kind.MACHINE: {
        *("execute", "sleep", "is_locked", "transition_allowed", "is_transition_allowed"),
        *("get_deep_state", "get_required_autonomy", "_execute_current_state", "_notify_skipped"),
    },
    Kind.BEHAVIOR: {"prepare_for_switch"},
}

# State of stock FlexBE's process that belongs to a run here.
_PROCESS_WIDE = {
    "OperatableStateMachine.autonomy_level": "the level belongs to a behavior",
    "PreemptableState.preempt": "a preempt belongs to a behavior; call its preempt()",
    "LockableStateMachine.path_for_switch": "a switch is asked for with a start request",
    "PriorityContainer.active_container": "priority belongs to a behavior",
}


def check_internals(module: Module, attributes: frozenset[str]) -> Iterator[Finding]:
    """Find what relies on the inside of stock FlexBE.

    Args:
        module: a user's file.
        attributes: names that states and containers of this engine have.
    """
    for found in module.classes:
        yield from _check_overrides(module, found)
        yield from _check_private(module, found, attributes)
    yield from _check_process(module)


def _check_overrides(module: Module, found: FlexbeClass) -> Iterator[Finding]:
    for name in sorted(OVERRIDES[found.kind] & set(found.methods)):
        text = (
            f"{found.node.name} overrides {name}() of a {found.kind.value}, which this engine does "
            "not call in a run; use on_start, on_enter, execute, on_exit and on_stop of states"
        )
        yield module.finding(found.methods[name], "override", Severity.ERROR, text)
    for node in ast.walk(found.node):
        targets = node.targets if isinstance(node, ast.Assign) else []
        if any(is_self_attribute(target) and target.attr == "execute" for target in targets):
            text = "self.execute is replaced: this engine calls the method of the class"
            yield module.finding(node, "override", Severity.ERROR, text)


def _check_private(
    module: Module, found: FlexbeClass, attributes: frozenset[str]
) -> Iterator[Finding]:
    nodes = [node for node in ast.walk(found.node) if is_self_attribute(node)]
    own = {node.attr for node in nodes if isinstance(node.ctx, ast.Store)}
    for node in nodes:
        is_read = isinstance(node.ctx, ast.Load)
        if is_read and node.attr in _PRIVATE[found.kind] - attributes - own:
            text = f"self.{node.attr} is stock FlexBE's own, and not there on this engine"
            yield module.finding(node, "private", Severity.ERROR, text)
        elif not is_read and node.attr in _PRIVATE[found.kind]:
            text = f"self.{node.attr} is FlexBE's own: setting it acts differently here; rename it"
            yield module.finding(node, "private", Severity.WARNING, text)
        elif not is_read and node.attr in _TOPICS and found.kind is Kind.STATE:
            text = f"self.{node.attr} breaks the state on stock FlexBE; rename it"
            yield module.finding(node, "private", Severity.NOTE, text)


def _check_process(module: Module) -> Iterator[Finding]:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            name = ".".join(module.dotted(node).split(".")[-2:])
            if name in _PROCESS_WIDE:
                text = f"{name} is set for the whole process: {_PROCESS_WIDE[name]}"
                yield module.finding(node, "process-wide", Severity.WARNING, text)


# What is left of Python 2


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


# What the FlexBE App cannot read, or loses, by the rules of app_load.py


_RULE = "app"
_PLACE = re.compile(r"line (\d+): ")

# Works on every engine; only the App, and only in behaviors that it saves, loses the transition.
_ONLY_IN_THE_APP = "reads outcome "


def check_app(module: Module, known: Known) -> Iterator[Finding]:
    """Find what the App does not see of states, and what it cannot load or loses of behaviors.

    Args:
        module: a user's file.
        known: the states and behaviors that the App would find.
    """
    for text in judge_state(module.text, module.file):
        place = _PLACE.match(text)
        line = int(place[1]) if place else 1
        severity = Severity.NOTE if _ONLY_IN_THE_APP in text else Severity.WARNING
        yield module.finding(line, _RULE, severity, _PLACE.sub("", text, count=1))
    for found in module.classes:
        if found.kind is Kind.BEHAVIOR:
            try:
                _, lost = load_behavior(module.text, known)
                if lost:
                    text = f"the App would not keep all of it when it saves it: {'; '.join(lost)}"
                    yield module.finding(found.node, _RULE, Severity.NOTE, text)
            except AppLoadError as error:
                text = f"the App cannot load it: {error}"
                yield module.finding(found.node, _RULE, Severity.WARNING, text)
