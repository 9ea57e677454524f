"""Find test cases and read them: their files, YAML, and the bags that they name."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import genpy
import rosbag
import roslib.message
import yaml

from flexbe_core import behavior_library
from flexbe_testing.core.case import Case, CaseError, read_case

_SUFFIX = ".test"
_FOLDER = "tests"


def case_files(names: Sequence[str], package: str) -> list[Path]:
    """Return the files of test cases.

    Args:
        names: paths, absolute or relative to the package, with or without .test; for none, all of
            the package's folder tests/.
        package: name of a ROS package; may be empty if all paths are absolute.

    Raises:
        CaseError: if one cannot be found.
    """
    folder = behavior_library.package_folder(package) if package else Path.cwd()
    if folder is None:
        raise CaseError(f"there is no ROS package {package!r}")
    if not names:
        found = sorted(folder.glob(f"{_FOLDER}/*{_SUFFIX}")) if package else []
        return [file for file in found if not file.read_bytes().lstrip().startswith(b"<")]
    return [_case_file(name, folder) for name in names]


def read_case_file(file: Path) -> Case:
    """Return the test case in a file.

    Raises:
        CaseError: if it is invalid.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(f"cannot read it: {error}") from error
    return read_case(file.stem, load_case(text))


def resource(name: str) -> Path:
    """Return a file that is named absolutely, from home, or as package/folder/file.

    Raises:
        CaseError: if there is no such package.
    """
    try:
        return behavior_library.named_file(name)
    except FileNotFoundError as error:
        raise CaseError(str(error)) from error


def _case_file(name: str, folder: Path) -> Path:
    path = behavior_library.named_file(name) if name.startswith("~") else Path(name)
    tried = [folder / path, folder / _FOLDER / path]
    tried += [candidate.with_name(candidate.name + _SUFFIX) for candidate in tuple(tried)]
    for candidate in tried:
        if candidate.is_file():
            return candidate
    raise CaseError(f"there is no test case {name!r}; tried {', '.join(map(str, tried))}")


# Read a test case's YAML, with the tags for Python objects that are harmless.
#
# Test cases hold messages as PyYAML dumps them, `!!python/object/new:std_msgs.msg._String.String`.
# Such a tag can name any class or function of any module, so only those are constructed whose
# construction does nothing else: ROS messages, times, and the containers of Python.


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
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # ValueError: of a wrong date
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


# Messages for tests, out of a bag


class BagMessages:
    """The messages of a bag, each topic in the order of recording."""

    def __init__(self, file: Path | None) -> None:
        """Read from `file`; None if the test case has no bag."""
        self._file = file
        self._topics: dict[str, Iterator[Any]] = {}

    def next_of(self, topic: str) -> Any:  # noqa: ANN401 - any type of message
        """Return the next message of a topic.

        Raises:
            CaseError: if there is no bag, or no further message.
        """
        if self._file is None:
            raise CaseError(f"value !{topic} needs a bag; name one as data")
        if topic not in self._topics:
            self._topics[topic] = self._messages(topic)
        try:
            return next(self._topics[topic])
        except StopIteration:
            text = f"bag {self._file} has no further message of topic {topic!r}"
            raise CaseError(text) from None

    def _messages(self, topic: str) -> Iterator[Any]:
        try:
            with rosbag.Bag(str(self._file)) as bag:
                found = [message for _, message, _ in bag.read_messages(topics=[topic])]
        except (OSError, rosbag.ROSBagException) as error:
            raise CaseError(f"cannot read bag {self._file}: {error}") from error
        return iter(found)
