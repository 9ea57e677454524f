"""The source of an ability's FlexBE state.

The FlexBE App reads a state as text: its base is `EventState` itself, its docstring follows the
App's grammar, and all arguments of the constructor are on the line of its `def`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence

from remodel_states.core.contract import GRACE_S
from remodel_states.core.tables import (
    PLAIN_TYPES,
    POSE,
    POSES,
    Ability,
    AbilityState,
    Parameter,
)

_WIDTH = 100
_BY = "generated from config/abilities.yaml: change that"

_ERRORS = """\
    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.
"""
_FAILURES = """\
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.
"""
_ENDS = '''
    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
'''


def module_name(ability: str) -> str:
    """Return the name of the module of an ability's state, such as "insert_cable_state"."""
    return f"{snake_case(ability)}_state"


def snake_case(name: str) -> str:
    """Return a name such as "InsertCable" in lower case with underscores."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def state_modules(abilities: Iterable[Ability]) -> dict[str, str]:
    """Return the modules of the abilities that have a state: name of the file -> source."""
    return {f"{module_name(each.name)}.py": state_source(each) for each in abilities if each.state}


def state_source(ability: Ability) -> str:
    """Return the module of an ability that has a state."""
    state = ability.state
    if state is None:
        raise ValueError(f"{ability.name} has no state in its table")
    return "".join(
        (
            f'"""The state of {ability.name}, {_BY}."""\n\n',
            _imports(ability, state),
            f"\n\nclass {ability.name}State(EventState):\n",
            _docstring(ability, state),
            _constructor(ability, state),
            _on_enter(ability, state),
            _execute(state),
            _ENDS,
        )
    )


def _imports(ability: Ability, state: AbilityState) -> str:
    name, package = ability.name, ability.package
    types = {parameter.field.type for parameter in state.parameters}
    helpers = ["from remodel_states.ability_call import AbilityCall"]
    checks = ["checked_byte"] * ("uint8" in types) + ["panel_pose"] * bool(types & {POSE, POSES})
    if checks:
        helpers.append(f"from remodel_states.parameters import {', '.join(checks)}")
    messages = f"from {package}.msg import {name}Action, {name}Goal"
    return "\n".join([messages, "", "from flexbe_core import EventState", *helpers, ""])


def _docstring(ability: Ability, state: AbilityState) -> str:
    lines = [
        f"-- {p.name}  {PLAIN_TYPES.get(p.field.type, 'list')}  {_parameter_text(p)}"
        for p in state.parameters
    ]
    lines += [f"-- timeout_s  float  [s] ROS time that the ability gets [grace {GRACE_S:g} s]."]
    lines += ["-- topic  string  Action topic of the ability server.", ""]
    lines += [
        f"># {i.name}  {PLAIN_TYPES.get(i.type, i.type)}  {_text(i.text)}" for i in state.inputs
    ]
    lines += [""] if state.inputs else []
    outputs = state.outputs.items()
    lines += [f"#> {k}  {PLAIN_TYPES.get(f.type, f.type)}  {_text(f.text)}" for k, f in outputs]
    writes = ", ".join(state.outputs) or "nothing"
    body = "".join(f"    {line}\n" if line else "\n" for line in lines)
    done = f"    <= {state.outcome}  [writes {writes}] {state.means}\n"
    text = f"{_text(ability.action.title)}\n\n{body}{_ERRORS}\n{done}{_FAILURES}\n    "
    plain = text.replace("\\", "\\\\").replace('"""', "'''")
    return f'    """{plain}"""\n\n'


def _parameter_text(parameter: Parameter) -> str:
    text = parameter.field.text
    if parameter.field.type in (POSE, POSES):
        form = "[x, y, z, yaw]" if parameter.field.type == POSE else "[[x, y, z, yaw], ...]"
        text = f"{form} in the panel frame [m, rad], {text.split(';')[0]}"
    return _text(text)


def _text(text: str) -> str:
    """Return a comment as a sentence."""
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def _constructor(ability: Ability, state: AbilityState) -> str:
    arguments = [
        p.name if p.is_required else f"{p.name}={_literal(p.default)}" for p in state.parameters
    ]
    signature = ", ".join(
        ["self", *arguments, f"timeout_s={state.timeout_s!r}", f"topic={_literal(ability.topic)}"]
    )
    line = f"    def __init__({signature}):"
    line += "  # fmt: skip" if len(line) > _WIDTH else ""
    keywords = [
        _list("outcomes", [state.outcome, "failed", "command_error"]),
        _list("input_keys", [item.name for item in state.inputs]),
        _list("output_keys", [*state.outputs, "error_code", "error_message"]),
    ]
    kept = [f"        self._{p.name} = {_checked(p)}\n" for p in state.parameters]
    call = ["self", f"{ability.name}Action", "topic", "timeout_s", f'done="{state.outcome}"']
    return "".join(
        (
            f'{line}\n        """Connect to the ability server."""\n',
            f"        super().__init__(\n{''.join(keywords)}        )\n",
            *kept,
            _wrapped("        self._call = AbilityCall", call),
        )
    )


def _checked(parameter: Parameter) -> str:
    if parameter.field.type == "uint8":
        return f'checked_byte("{parameter.name}", {parameter.name})'
    return parameter.name


def _list(keyword: str, items: Sequence[str]) -> str:
    """Return a keyword argument that is a list of texts, with its comma."""
    texts = [_literal(item) for item in items]
    line = f"            {keyword}=[{', '.join(texts)}],\n"
    if len(line) <= _WIDTH + 1:
        return line
    return f"            {keyword}=[\n{_one_per_line(texts, 16)}            ],\n"


def _literal(value: object) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _wrapped(head: str, arguments: Sequence[str]) -> str:
    """Return a call as ruff lays it out: on one line, with its arguments on one, or one each."""
    indent = len(head) - len(head.lstrip())
    line, inner = f"{head}({', '.join(arguments)})", " " * (indent + 4) + ", ".join(arguments)
    if len(line) <= _WIDTH:
        return f"{line}\n"
    if len(inner) <= _WIDTH:
        return f"{head}(\n{inner}\n{' ' * indent})\n"
    return f"{head}(\n{_one_per_line(arguments, indent + 4)}{' ' * indent})\n"


def _one_per_line(texts: Sequence[str], indent: int) -> str:
    return "".join(f"{' ' * indent}{text},\n" for text in texts)


def _on_enter(ability: Ability, state: AbilityState) -> str:
    given = {item.name: f"userdata.{item.name}" for item in state.inputs}
    given |= {parameter.field.name: _given(parameter) for parameter in state.parameters}
    ordered = [f"{f.name}={given[f.name]}" for f in ability.action.goal if f.name in given]
    return (
        f'\n    def on_enter(self, userdata):\n        """Send the goal."""\n'
        f"        self._call.start(\n            {ability.name}Goal(\n"
        f"{_one_per_line(ordered, 16)}            )\n        )\n"
    )


def _given(parameter: Parameter) -> str:
    value = f"self._{parameter.name}"
    if parameter.field.type == POSE:
        return f"panel_pose({value})"
    if parameter.field.type == POSES:
        return f"[panel_pose(pose) for pose in {value}]"
    return value


def _execute(state: AbilityState) -> str:
    writes = "".join(
        f"            userdata.{key} = self._call.result.{field.name}\n"
        for key, field in state.outputs.items()
    )
    written = f'        if outcome == "{state.outcome}":\n{writes}' if writes else ""
    return (
        '\n    def execute(self, userdata):\n        """Return the outcome once the ability has '
        'ended."""\n        outcome = self._call.outcome()\n        if outcome is not None:\n'
        f"            self._call.write_errors(userdata)\n{written}        return outcome\n"
    )


# A new package for one ability, from templates


_SUFFIX = ".in"
_ABILITY = re.compile(r"([A-Z][a-z0-9]+){2,}")
_PACKAGE = re.compile(r"[a-z][a-z0-9_]+")


def name_problems(ability: str, package: str) -> list[str]:
    """Return what is wrong with the names of an ability and its package."""
    problems = []
    if not _ABILITY.fullmatch(ability):
        problems.append(f"ability {ability!r}: allowed: a verb and a noun such as CrimpFerrule")
    if not _PACKAGE.fullmatch(package):
        problems.append(f"package {package!r}: allowed: lower case such as crimp_ferrule")
    return problems


def package_files(
    templates: Mapping[str, str], ability: str, package: str, code: int
) -> dict[str, str]:
    """Return the files of the package: path in it -> text.

    Args:
        templates: path, with the suffix ".in" -> text.
        ability: name of the action, such as "CrimpFerrule".
        package: name of the package.
        code: number of its first error code.
    """
    module = snake_case(ability)
    values = {
        "ability": ability,
        "package": package,
        "module": module,
        "topic": ability.lower(),
        "title": module.replace("_", " ").title(),
        "code": f"{module.upper()}_FAILED",
        "number": str(code),
    }
    return {
        _filled(path, values).removesuffix(_SUFFIX): _filled(text, values)
        for path, text in templates.items()
    }


def _filled(text: str, values: Mapping[str, str]) -> str:
    return re.sub(r"@(\w+)@", lambda match: values[match[1]], text)
