"""Read a test case's YAML, with the tags for Python objects that are harmless.

Test cases hold messages as PyYAML dumps them, `!!python/object/new:std_msgs.msg._String.String`.
Such a tag can name any class or function of any module, so only those are constructed whose
construction does nothing else: ROS messages, times, and the containers of Python.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import genpy
import roslib.message
import yaml

from flexbe_testing.errors import CaseError

_TAG = "tag:yaml.org,2002:python/"
_MESSAGE = re.compile(r"(\w+)\.msg(?:\._\w+)?\.(\w+)\Z")
_TIMES = {
    f"{module}.rostime.{name}": kind
    for module in ("genpy", "rospy")
    for name, kind in (("Time", genpy.Time), ("Duration", genpy.Duration))
}
_ALLOWED = "ROS messages, times and durations, tuples, lists, dictionaries, numbers and texts"
_SCALARS: dict[str, Callable[[str], object]] = {
    "str": str,
    "unicode": str,
    "int": int,
    "long": int,
    "float": float,
    "complex": complex,
    "bool": lambda text: text == "True",
    "none": lambda text: None,
}
_SEQUENCES: dict[str, Callable[[list[Any]], object]] = {"tuple": tuple, "list": list}
_WORDS = {f"tag:yaml.org,2002:{kind}" for kind in ("bool", "int", "float")}


def load_case(text: str) -> object:
    """Return what the text of a test case holds.

    Raises:
        CaseError: if it is not YAML, or has a tag that is not constructed; with its line.
    """
    try:
        return yaml.load(text, _CaseLoader)
    except yaml.constructor.ConstructorError as error:
        mark = error.problem_mark
        where = f"line {mark.line + 1}: " if mark else ""
        raise CaseError(f"{where}{error.problem}") from error
    except yaml.YAMLError as error:
        raise CaseError(f"cannot read it: {error}") from error


class _CaseLoader(yaml.SafeLoader):
    """Constructs plain YAML, and what the tags for harmless Python objects name."""

    def get_single_node(self) -> yaml.Node | None:
        """Return the document; an outcome is text, even one that YAML takes for `true`."""
        root: yaml.Node | None = super().get_single_node()
        for key, value in root.value if isinstance(root, yaml.MappingNode) else ():
            if getattr(key, "value", None) == "outcome" and value.tag in _WORDS:
                value.tag = "tag:yaml.org,2002:str"
        return root


def _construct_python(loader: _CaseLoader, suffix: str, node: yaml.Node) -> object:
    """Return the object that a tag of Python names."""
    form, _, name = suffix.partition(":")
    if form in _SCALARS and isinstance(node, yaml.ScalarNode):
        return _or_refuse(node, lambda: _SCALARS[form](str(node.value)))
    if form in _SEQUENCES and isinstance(node, yaml.SequenceNode):
        return _SEQUENCES[form](loader.construct_sequence(node, deep=True))
    if form == "dict" and isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if form == "object/apply" and name == "collections.OrderedDict":
        return _or_refuse(node, lambda: dict(*loader.construct_sequence(node, deep=True)))
    if form in ("object", "object/new"):
        return _construct_object(loader, name, node)
    raise _refusal(node, f"the tag !!python/{suffix} is not allowed; allowed are {_ALLOWED}")


def _construct_object(loader: _CaseLoader, name: str, node: yaml.Node) -> object:
    found = _MESSAGE.match(name)
    kind = _TIMES.get(name)
    if found:
        kind = roslib.message.get_message_class(f"{found[1]}/{found[2]}")
        if kind is None:
            raise _refusal(node, f"there is no message {found[1]}/{found[2]} in this workspace")
    if kind is None:
        raise _refusal(node, f"objects of {name} are not constructed; allowed are {_ALLOWED}")
    values = _field_values(loader, node, kind.__slots__)
    return _or_refuse(node, lambda: _filled(kind, values))


def _field_values(loader: _CaseLoader, node: yaml.Node, fields: Sequence[str]) -> list[Any]:
    """Return the value of each field: from the list that PyYAML writes, or by name."""
    given: object = None
    if isinstance(node, yaml.SequenceNode):
        given = loader.construct_sequence(node, deep=True)
    elif isinstance(node, yaml.MappingNode):
        entries = loader.construct_mapping(node, deep=True)
        given = entries.get("state", entries.get("args", entries))
    if isinstance(given, dict) and set(given) == set(fields):
        return [given[field] for field in fields]
    if isinstance(given, list) and len(given) == len(fields):
        return given
    raise _refusal(node, f"its fields are {', '.join(fields)}; found {given!r:.200}")


def _filled(kind: type, values: list[Any]) -> object:
    if issubclass(kind, genpy.TVal):
        return kind(*values)
    message = kind(*values)
    message._check_types()  # raises genpy.MessageException: a wrong type of a field
    return message


def _or_refuse(node: yaml.Node, construct: Callable[[], object]) -> object:
    try:
        return construct()
    except (TypeError, ValueError, genpy.MessageException) as error:
        raise _refusal(node, f"{node.tag.removeprefix(_TAG)}: {error}") from error


def _refusal(node: yaml.Node, text: str) -> yaml.constructor.ConstructorError:
    return yaml.constructor.ConstructorError(None, None, text, node.start_mark)


_CaseLoader.add_multi_constructor(_TAG, _construct_python)
