"""What the doctor examines and finds in a file and its classes, states that block among it.

The engine executes states when something arrives for them, and at their rate while they wait. All
states of a behavior share one thread: while one does not return, no command and no state acts.
"""

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
        above = f"{folder.rstrip('/')}/"
        lines = [
            f"{f.file.removeprefix(above)}:{f.line}: {f.severity.value} [{f.rule}] {f.text}"
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
    try:
        tree = ast.parse(text, file)
    except (ValueError, MemoryError, RecursionError) as error:  # null bytes; too many brackets
        raise SyntaxError(str(error) or "it is nested too deeply") from error
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


_RUNNING = ("execute", "on_enter", "on_exit", "on_resume", "on_pause")
_SLEEPS = {"time.sleep", "rospy.sleep", "rospy.rostime.sleep"}
_WAITS = {"rospy.wait_for_message", "rospy.wait_for_service", "rospy.spin"}
_WAITS |= {"subprocess.call", "subprocess.check_call", "subprocess.check_output", "subprocess.run"}
_WAITS |= {"os.system"}
_WAITING_METHODS = {"wait_for_result", "send_goal_and_wait", "wait_for_server", "waitForTransform"}
_CLOCKS = {"rospy.Time.now", "rospy.get_time", "rospy.get_rostime", "time.time", "time.monotonic"}
_DIRECT = {
    "rospy.Subscriber": "ProxySubscriberCached",
    "message_filters.Subscriber": "ProxySubscriberCached",
    "actionlib.SimpleActionClient": "ProxyActionClient",
    "actionlib.ActionClient": "ProxyActionClient",
}
_BLOCKS = "until it returns, no preempt, pause or other state acts"


def check_blocking(module: Module) -> Iterator[Finding]:
    """Find what is wrong in methods that the engine calls while a behavior runs."""
    for found in module.classes:
        if found.kind is not Kind.STATE:
            continue
        for method in found.reached(_RUNNING):
            yield from _check_method(module, method)
        yield from _check_polling(module, found)


def _check_method(module: Module, method: ast.FunctionDef) -> Iterator[Finding]:
    rates = _rates(module, method)
    for node in ast.walk(method):
        if isinstance(node, ast.While) and _waits_in_loop(module, node):
            text = f"a loop that waits inside {method.name}: {_BLOCKS}; return None instead"
            yield module.finding(node, "loop", Severity.ERROR, text)
        if not isinstance(node, ast.Call):
            continue
        name = module.dotted(node.func)
        if name in _SLEEPS or _is_rate_sleep(node, rates):
            what = name or "a rate"
            text = f"{what} sleeps in {method.name}: {_BLOCKS}; return None, or wake_at(...)"
            yield module.finding(node, "sleep", Severity.ERROR, text)
        elif name in _WAITS or name.rpartition(".")[2] in _WAITING_METHODS:
            text = f"{name} blocks in {method.name}: {_BLOCKS}; use a proxy and poll it"
            yield module.finding(node, "wait", Severity.WARNING, text)
        elif name == "rospy.Rate":
            text = f"a rospy.Rate in {method.name}: the engine has the rate; use self.set_rate(hz)"
            yield module.finding(node, "rate", Severity.WARNING, text)


def _rates(module: Module, method: ast.FunctionDef) -> set[str]:
    """Return the local names that hold a rospy.Rate."""
    return {
        target.id
        for node in ast.walk(method)
        if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Call)
        and module.dotted(node.value.func) == "rospy.Rate"
        for target in node.targets
        if isinstance(target, ast.Name)
    }


def _is_rate_sleep(node: ast.Call, rates: set[str]) -> bool:
    if not isinstance(node.func, ast.Attribute) or node.func.attr != "sleep":
        return False
    owner = node.func.value
    if isinstance(owner, ast.Name):
        return owner.id in rates
    return is_self_attribute(owner) and "rate" in owner.attr.lower()


def _waits_in_loop(module: Module, loop: ast.While) -> bool:
    """Return whether a loop continues until something outside changes."""
    tested = {
        module.dotted(node.func) for node in ast.walk(loop.test) if isinstance(node, ast.Call)
    }
    if "rospy.is_shutdown" in tested:
        return True
    for node in ast.walk(loop):
        if isinstance(node, ast.Call):
            name = module.dotted(node.func)
            if name in _SLEEPS or name.endswith(".sleep"):
                return True
    return False


def _check_polling(module: Module, found: FlexbeClass) -> Iterator[Finding]:
    execute = found.methods.get("execute")
    if execute is None:
        return
    yield from _check_counting(module, execute)
    calls = {
        module.dotted(node.func): node
        for node in ast.walk(found.node)
        if isinstance(node, ast.Call)
    }
    for method in found.reached(("execute",)):
        for node in ast.walk(method):
            is_clock = isinstance(node, ast.Call) and module.dotted(node.func) in _CLOCKS
            if is_clock and not any(name.endswith("wake_at") for name in calls):
                text = "waits for a time by polling at its rate; flexbe_core.wake_at(time) is exact"
                yield module.finding(node, "polls-time", Severity.NOTE, text)
    for name, proxy in _DIRECT.items():
        if name in calls:
            text = f"{name} does not wake the state: it notices at its rate; use {proxy}"
            yield module.finding(calls[name], "no-wake-up", Severity.NOTE, text)


def _check_counting(module: Module, execute: ast.FunctionDef) -> Iterator[Finding]:
    """Find attributes that count executions, and are compared."""
    compared = {
        node.attr
        for test in ast.walk(execute)
        if isinstance(test, ast.Compare)
        for node in ast.walk(test)
        if is_self_attribute(node)
    }
    for node in ast.walk(execute):
        if not isinstance(node, ast.AugAssign) or not isinstance(node.value, ast.Constant):
            continue
        if is_self_attribute(node.target) and node.target.attr in compared:
            text = (
                f"execute counts its executions in self.{node.target.attr}, which do not measure "
                "time: a state is also executed when something arrives; compare rospy.get_time()"
            )
            yield module.finding(node, "counts-executions", Severity.WARNING, text)
