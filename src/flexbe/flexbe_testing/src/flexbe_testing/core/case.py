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
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from flexbe_testing.errors import CaseError

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
