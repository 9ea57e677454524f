"""Run one test case."""

from __future__ import annotations

import importlib
import traceback
from typing import Any

import rospy

from flexbe_core import Behavior
from flexbe_core.core import State, UserData
from flexbe_core.engine.supervision.in_force import UNSUPERVISED
from flexbe_testing.core.case import Case
from flexbe_testing.core.values import value_of
from flexbe_testing.core.verdict import PASS, Check, Verdict, compare, not_run
from flexbe_testing.edge.bag_messages import BagMessages
from flexbe_testing.edge.case_files import resource
from flexbe_testing.errors import CaseError
from flexbe_testing.ros.surroundings import surroundings


def run_case(case: Case) -> Verdict:
    """Run a test case; whatever goes wrong is a complaint of its result `pass`."""
    try:
        tested = _import(case)
        if case.import_only:
            return Verdict(case.title)
        messages = BagMessages(resource(case.bag) if case.bag else None)
        with surroundings(case) as launched:
            checks = _run(case, tested, messages)
            complaint = ""
            if launched is not None and case.require_launch_success and launched.poll():
                complaint = f"what was launched ended with {launched.returncode}"
        return Verdict(case.title, (Check(PASS, complaint), *checks))
    except CaseError as error:
        return not_run(case, str(error))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever the tested code raises
        return not_run(case, f"{type(error).__name__}: {error}\n{traceback.format_exc()}")


def _import(case: Case) -> type:
    try:
        module = importlib.import_module(case.module)
    except Exception as error:
        raise CaseError(f"cannot import {case.module}: {type(error).__name__}: {error}") from error
    tested = getattr(module, case.class_name, None)
    if not isinstance(tested, type):
        raise CaseError(f"module {case.module} has no class {case.class_name!r}")
    if not issubclass(tested, Behavior | State):
        raise CaseError(f"{case.class_name} is neither a state nor a behavior")
    return tested


def _run(case: Case, tested: type, messages: BagMessages) -> tuple[Check, ...]:
    params, inputs, expected = (
        value_of(dict(written), messages.next_of, bool(case.bag))
        for written in (case.params, case.inputs, case.outputs)
    )
    run = _run_behavior if issubclass(tested, Behavior) else _run_state
    outcome, outputs = run(tested, params, inputs)
    return compare(case.outcome, outcome, expected, outputs)


def _run_state(
    tested: type[State], params: dict[str, Any], inputs: dict[str, Any]
) -> tuple[str | None, dict[str, Any]]:
    """Execute a state by hand until it ends, as the only one of a behavior."""
    state = tested(**params)
    userdata = UserData(input_keys=state.input_keys, output_keys=state.output_keys)
    outputs: dict[str, Any] = {}
    userdata(reference=outputs)
    outputs.update(inputs)
    outcome = None
    state.on_start()
    try:
        while outcome is None and not rospy.is_shutdown():
            outcome = state.execute(userdata)
            if outcome is None:
                state.sleep()
    finally:
        state.on_stop()
    return outcome, outputs


def _run_behavior(
    tested: type[Behavior], params: dict[str, Any], inputs: dict[str, Any]
) -> tuple[str | None, dict[str, Any]]:
    behavior = tested()
    for name, value in params.items():
        if not behavior.set_parameter(name, value):
            raise CaseError(f"behavior {behavior.name!r} has no parameter {name!r}")
    behavior.set_up(id=0, autonomy_level=UNSUPERVISED, debug=False)
    behavior.prepare_for_execution(inputs)
    behavior.confirm()
    outcome = behavior.execute()
    return outcome, behavior.get_userdata().get("", {})
