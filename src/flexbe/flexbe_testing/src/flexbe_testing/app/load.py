"""Load a behavior's file as the App does."""

from __future__ import annotations

import re
from collections.abc import Iterator

from flexbe_testing.app import text as cut
from flexbe_testing.app.behavior import AppBehavior, BehaviorDefinition
from flexbe_testing.app.known import Known
from flexbe_testing.app.load_create import CreateSection
from flexbe_testing.app.text import AppLoadError

_CLASS = re.compile(r"^\s*class\s+(\w+)\s*\((.*)\):", re.MULTILINE)
_CREATED = re.compile(r"\n'''\nCreated on ([^'\n]*)\n@author: ([^'\n]*)\n'''\s*\nclass ")
_DESCRIPTION = re.compile(r"^\s*class .*\n\s*'''([^']*)'''", re.MULTILINE)
_NAME = re.compile(r"self\.name = ['\"]([^'\"\n]*)['\"][ \t]*$", re.MULTILINE)
_PARAMETER = re.compile(r"self\.add_parameter\(['\"](\w+)['\"], (.*)\)[ \t]*$", re.MULTILINE)
_IMPORT = re.compile(r"from [\w.]+ import \w+(?: as \w+)?")
_CORE_IMPORT = "from flexbe_core import "
_COMMENTS = "# Behavior comments:"
_INIT, _CREATE = "def __init__(self):", "def create(self):"


def load_behavior(text: str, known: Known) -> AppBehavior:
    """Return what the App makes of a behavior's file.

    Raises:
        AppLoadError: if the App cannot load it.
    """
    manual = cut.manual_sections(text)
    read = cut.without_manual(text)
    class_name = _class_name(read)
    for head in (_INIT, _CREATE):
        if read.count(head) != 1:
            raise AppLoadError(f"not exactly one '{head}'")
    init = cut.section(read, _INIT)
    name = _NAME.search(init)
    if name is None:
        raise AppLoadError("no self.name in quotes, free of quotes itself")
    lost = list(_lost_outside_create(text, read, init))
    create = CreateSection(cut.section(read, _CREATE), known, lost)
    created, description = _CREATED.search(read), _DESCRIPTION.search(read)
    return AppBehavior(
        name=name[1],
        class_name=class_name,
        description=description[1].strip() if description else "",
        author=created[2] if created else "",
        date=created[1] if created else "",
        parameters=dict(_PARAMETER.findall(init)),
        notes=_notes(init),
        private=create.private(),
        userdata=create.userdata(),
        manual=manual,
        root=create.root(),
        lost=tuple(lost),
    )


def define_behavior(text: str, module: str) -> BehaviorDefinition:
    """Return what the App knows of a behavior that others contain.

    Raises:
        AppLoadError: if the App cannot load it.
    """
    read = cut.without_manual(text)
    init = cut.section(read, _INIT)
    name = _NAME.search(init)
    root = CreateSection(cut.section(read, _CREATE), Known(), []).interface()
    return BehaviorDefinition(
        name[1] if name else "",
        _class_name(read),
        module,
        root.outcomes,
        input_keys=root.input_keys,
        output_keys=root.output_keys,
        parameters=tuple(dict(_PARAMETER.findall(init))),
    )


def _class_name(read: str) -> str:
    classes = _CLASS.findall(read)
    if [bases for _name, bases in classes] != ["Behavior"]:
        raise AppLoadError("not exactly one class, with the base list (Behavior)")
    return str(classes[0][0])


def _notes(init: str) -> str:
    lines = (line.strip() for line in init.partition(_COMMENTS)[2].splitlines())
    return "\n".join(line for line in lines if line)


def _lost_outside_create(text: str, read: str, init: str) -> Iterator[str]:
    """Yield what is not read of a file, `create` left out."""
    if "\r" in text:
        yield "line ends other than LF are not read"
    if not _CREATED.search(read):
        yield "no block with date and author before the class"
    if not _DESCRIPTION.search(read):
        yield "no docstring in triple single quotes, free of apostrophes"
    if _COMMENTS not in init:
        yield f"__init__ ends early, because it contains ' def ', or has no '{_COMMENTS}'"
    for tag in cut.MANUAL_TAGS:
        if text.count(f"# [MANUAL_{tag}]") > 1:
            yield f"the tags of MANUAL_{tag} occur more than once: the App loses the section"
    for line in read.splitlines():
        is_import = re.match(r"\s*(from|import)\s", line) and not line.startswith(_CORE_IMPORT)
        if is_import and not _IMPORT.fullmatch(line):
            yield f"an import in another form than 'from a.b import C' is not read: {line}"
