"""States that hold the engine up, or count on being polled.

The engine executes states when something arrives for them, and at their rate while they wait. All
states of a behavior share one thread: while one does not return, no command and no state acts.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from flexbe_testing.core.doctor.module import (
    Finding,
    FlexbeClass,
    Kind,
    Module,
    Severity,
    is_self_attribute,
)

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
