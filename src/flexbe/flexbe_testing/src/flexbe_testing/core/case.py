"""A test case: what to run, with which inputs, and the expected result.

path: flexbe_states.calculation_state   module of a state; with `name`, package of a behavior
class: CalculationState                 class of a state or behavior
name: Example Behavior                  display name of a behavior, instead of a class
import_only: true                       only import it, and construct nothing
params: {calculation: "lambda x: 2 * x"}
input: {input_value: 2}
output: {output_value: 4}
outcome: done
data: package/folder/some.bag           where values written as /topic come from
launch: package/folder/some.launch      or the XML itself: what runs beside the test
wait_cond: "rospy.has_param('/ready')"  Python, true when what was launched is ready
require_launch_success: true            whether what was launched must still run at the end
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


class CaseError(Exception):
    """A test case that cannot be run; the text says why."""


_KINDS: dict[str, type] = {
    "path": str,
    "class": str,
    "name": str,
    "import_only": bool,
    "params": dict,
    "input": dict,
    "output": dict,
    "outcome": str,
    "data": str,
    "launch": str,
    "wait_cond": str,
    "require_launch_success": bool,
}


@dataclass(frozen=True)
class Case:
    """A test case.

    Attributes:
        title: what the test is called.
        module: dotted path of the module under test.
        class_name: class under test.
        import_only: whether it is only imported.
        params: parameters of the state or behavior, as written in the case.
        inputs: its userdata, as written.
        outputs: expected userdata, as written.
        outcome: expected outcome; None for any.
        bag: file with messages that values are taken from; empty for none.
        launch: launch file, or its XML; empty for none.
        wait_cond: expression that is true when what was launched is ready; empty for none.
        require_launch_success: whether what was launched must still run at the end.
    """

    title: str
    module: str
    class_name: str
    import_only: bool = False
    params: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, Any] = field(default_factory=dict)
    outcome: str | None = None
    bag: str = ""
    launch: str = ""
    wait_cond: str = ""
    require_launch_success: bool = True


def read_case(title: str, found: object) -> Case:
    """Return the test case that a YAML file holds.

    Raises:
        CaseError: if it is invalid; the text lists all errors.
    """
    if not isinstance(found, dict):
        raise CaseError(f"a test case is a mapping of keys to values; found {found!r:.80}")
    entries = {str(key): value for key, value in found.items() if value not in (None, "None")}
    wrong = [
        f"{key} must be of type {_KINDS[key].__name__}, found {value!r:.80}"
        for key, value in entries.items()
        if key in _KINDS and not isinstance(value, _KINDS[key])
    ]
    wrong += [f"{key} is unknown" for key in entries if key not in _KINDS]
    if "path" not in entries:
        wrong.append("path is missing: the module of the state, or the package of the behavior")
    if "class" not in entries and "name" not in entries:
        wrong.append("class, or name of a behavior, is missing")
    if wrong:
        raise CaseError(f"{'; '.join(wrong)}. There are: {', '.join(_KINDS)}")
    module, class_name = entries["path"], entries.get("class", "")
    if "name" in entries:
        module, class_name = behavior_place(module, entries["name"])
    return Case(
        title=title,
        module=module,
        class_name=class_name,
        import_only=entries.get("import_only", False),
        params=entries.get("params", {}),
        inputs=entries.get("input", {}),
        outputs=entries.get("output", {}),
        outcome=entries.get("outcome"),
        bag=entries.get("data", ""),
        launch=entries.get("launch", ""),
        wait_cond=entries.get("wait_cond", ""),
        require_launch_success=entries.get("require_launch_success", True),
    )


def behavior_place(package: str, name: str) -> tuple[str, str]:
    """Return module and class of a behavior, by the rules of the FlexBE App."""
    base = re.sub(r"\W", "_", name.lower())
    return f"{package}.{base}_sm", re.sub(r"\W", "", name) + "SM"


# Values of a test case: as written, from a bag, or functions.
#
#     /topic           the next message of that topic in the case's bag; without a bag, this text
#     !/topic          the same, and an error without a bag
#     //text           the text `/text`
#     None             None
#     lambda x: x + 1  that function
#
# A test case names any module to import, so it is trusted as code is; that is why functions in it
# may be evaluated. Test cases come from files only, never from a message or a parameter.


_FROM_BAG = "!"
_FUNCTION = "lambda"


def value_of(written: object, message: Callable[[str], object], has_bag: bool = False) -> Any:  # noqa: ANN401 - whatever the tested state takes
    """Return what a value of a test case stands for.

    Args:
        written: as it is in the case.
        message: returns the next message of a topic.
        has_bag: whether the case names a bag.

    Raises:
        CaseError: if it is a function that is not Python.
    """
    if isinstance(written, dict):
        return {key: value_of(value, message, has_bag) for key, value in written.items()}
    if isinstance(written, list | tuple):
        return type(written)([value_of(value, message, has_bag) for value in written])
    return _text(written, message, has_bag) if isinstance(written, str) else written


def _text(written: str, message: Callable[[str], object], has_bag: bool) -> object:
    if written == "None":
        return None
    if written.startswith("//"):
        return written[1:]
    if written.startswith(_FROM_BAG + "/") or (has_bag and written.startswith("/")):
        return message(written.removeprefix(_FROM_BAG))
    if written.lstrip().startswith(_FUNCTION):
        return _function(written.strip())
    return written


def _function(text: str) -> object:
    try:
        return eval(text, {})
    except SyntaxError as error:
        raise CaseError(f"{text!r} is not a Python function: {error}") from error


# How a test ended: whether it ran, its outcome, and each of its outputs


PASS, OUTCOME, OUTPUT = "pass", "outcome", "output_"
_NOT_REACHED = "not reached, because the case did not run to its end"


@dataclass(frozen=True)
class Check:
    """One result of a test.

    Attributes:
        name: `pass`, `outcome`, or `output_` and the key.
        complaint: what is not as it should be; empty if nothing.
    """

    name: str
    complaint: str = ""


@dataclass(frozen=True)
class Verdict:
    """How a test ended.

    Attributes:
        title: what the test is called.
        checks: its results, of which `pass` is the first: whether the case ran to its end.
    """

    title: str
    checks: tuple[Check, ...] = (Check(PASS),)

    @property
    def complaints(self) -> tuple[str, ...]:
        """Return what was not as it should be; none if the test succeeded."""
        return tuple(check.complaint for check in self.checks if check.complaint)

    @property
    def is_good(self) -> bool:
        """Return whether the test succeeded."""
        return not self.complaints

    def check(self, name: str) -> Check:
        """Return the result of a name."""
        return next(check for check in self.checks if check.name == name)


def check_names(case: Case) -> tuple[str, ...]:
    """Return the names of the results that a case has."""
    if case.import_only:
        return (PASS,)
    outcome = () if case.outcome is None else (OUTCOME,)
    return (PASS, *outcome, *(f"{OUTPUT}{key}" for key in case.outputs))


def not_run(case: Case, complaint: str) -> Verdict:
    """Return the verdict of a case that did not run to its end."""
    rest = (Check(name, _NOT_REACHED) for name in check_names(case)[1:])
    return Verdict(case.title, (Check(PASS, complaint), *rest))


def compare(
    expected_outcome: str | None,
    outcome: str | None,
    expected: Mapping[str, Any],
    outputs: Mapping[str, Any],
) -> tuple[Check, ...]:
    """Return the results of a case that ran: of its outcome, and of each output."""
    checks = []
    if expected_outcome is not None:
        text = f"outcome is {outcome!r}; expected was {expected_outcome!r}"
        checks.append(Check(OUTCOME, "" if outcome == expected_outcome else text))
    for key, value in expected.items():
        complaint = ""
        if key not in outputs:
            complaint = f"output {key!r} was not written; expected was {value!r:.200}"
        elif outputs[key] != value:
            found = outputs[key]
            complaint = f"output {key!r} is {found!r:.200}; expected was {value!r:.200}"
        checks.append(Check(f"{OUTPUT}{key}", complaint))
    return tuple(checks)
