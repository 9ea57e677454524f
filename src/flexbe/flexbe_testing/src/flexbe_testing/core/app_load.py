"""Load a behavior's file as the App does."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from flexbe_testing.core import app_behavior as cut
from flexbe_testing.core.app_behavior import (
    AppLoadError,
    BehaviorDefinition,
    BehaviorUse,
    Child,
    Container,
    Known,
    Point,
    StateUse,
    without_blanks,
)

_CLASS = re.compile(r"^\s*class\s+(\w+)\s*\((.*)\):", re.MULTILINE)
_CREATED = re.compile(r"\n'''\nCreated on ([^'\n]*)\n@author: ([^'\n]*)\n'''\s*\nclass ")
_DESCRIPTION = re.compile(r"^\s*class .*\n\s*'''([^']*)'''", re.MULTILINE)
_NAME = re.compile(r"self\.name = ['\"]([^'\"\n]*)['\"][ \t]*$", re.MULTILINE)
_IMPORT = re.compile(r"from [\w.]+ import \w+(?: as \w+)?")
_CORE_IMPORT = "from flexbe_core import "
_COMMENTS = "# Behavior comments:"
_INIT, _CREATE = "def __init__(self):", "def create(self):"


def load_behavior(text: str, known: Known) -> tuple[Container, tuple[str, ...]]:
    """Return what the App makes of a behavior's file.

    Returns:
        its containers and states, and complaints about what the App does not take from the file:
        it is gone once saved.

    Raises:
        AppLoadError: if the App cannot load it.
    """
    cut.manual_sections(text)
    read = cut.without_manual(text)
    _class_name(read)
    for head in (_INIT, _CREATE):
        if read.count(head) != 1:
            raise AppLoadError(f"not exactly one '{head}'")
    init = cut.section(read, _INIT)
    if _NAME.search(init) is None:
        raise AppLoadError("no self.name in quotes, free of quotes itself")
    lost = list(_lost_outside_create(text, read, init))
    root = CreateSection(cut.section(read, _CREATE), known, lost).root()
    return root, tuple(lost)


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
    )


def _class_name(read: str) -> str:
    classes = _CLASS.findall(read)
    if [bases for _name, bases in classes] != ["Behavior"]:
        raise AppLoadError("not exactly one class, with the base list (Behavior)")
    return str(classes[0][0])


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


# Load the method `create` of a behavior: containers and what they hold


_PLACES = r"(?:# (x:-?\d+ y:-?\d+(?:, x:-?\d+ y:-?\d+)*)[ \t]*\n\s*)?"
_PLAIN = re.compile(_PLACES + r"(\w+) = (OperatableStateMachine|PriorityContainer)\(([^)]*)\)")
_CONCURRENT = re.compile(
    _PLACES + r"(\w+) = (ConcurrencyContainer)\(([^)]*?)conditions=\[\n(.*?)\s\]\)\n", re.DOTALL
)
_CONDITION = re.compile(r"\('([^']+)', \[((?:\('[^']+', '[^']+'\)(?:, )?)+)\]\)")
_PAIR = re.compile(r"\('([^']+)', '([^']+)'\)")
_ADD = re.compile(
    r"(?:# x:(-?\d+) y:(-?\d+)(?: \{([^\n]*)\})?[ \t]*\n\s*)?OperatableStateMachine\.add\("
)
_WITH = re.compile(r"^[ \t]*with (\w+):", re.MULTILINE)
_ASSIGNED = re.compile(r"^[ \t]*(\w+) = (.*)$", re.MULTILINE)
_RETURNED = re.compile(r"^[ \t]+return (\w+)[ \t]*$", re.MULTILINE)
_INTERNAL = re.compile(r"(\?\w+) = (\[[^\]]*\]|[^,]+)")
_ESCAPED_QUOTE = re.compile(r"(?<!\\)(?:\\\\)*\\['\"]")
_DEFAULT_PLACE = (30, 40)
_MAPS = ("transitions", "autonomy", "remapping")


class CreateSection:
    """The text of `create`; what cannot be read is added to `lost`."""

    def __init__(self, text: str, known: Known, lost: list[str]) -> None:
        self._text, self._known, self._lost = text, known, lost
        self._definitions = {
            found[2]: _definition(found)
            for pattern in (_PLAIN, _CONCURRENT)
            for found in pattern.finditer(text)
        }
        starts = list(_WITH.finditer(text))
        ends = [start.start() for start in starts[1:]] + [len(text)]
        self._blocks = {
            start[1]: text[start.end() : end] for start, end in zip(starts, ends, strict=False)
        }

    def private(self) -> dict[str, str]:
        """Return all variables that are not containers."""
        found = dict(_ASSIGNED.findall(self._text))
        return {name: value for name, value in found.items() if name not in self._definitions}

    def interface(self) -> Container:
        """Return the root without its content.

        Raises:
            AppLoadError: if there is none.
        """
        returned = _RETURNED.search(self._text)
        if returned is None:
            raise AppLoadError("create does not return a variable, or ' def ' stands in it")
        if returned[1] not in self._definitions:
            raise AppLoadError(f"the definition of {returned[1]} is not read")
        return self._definitions[returned[1]]

    def root(self) -> Container:
        """Return the root with all it holds.

        Raises:
            AppLoadError: if the App cannot load it.
        """
        self.interface()
        if escaped := _ESCAPED_QUOTE.search("".join(self._blocks.values())):
            raise AppLoadError(
                f"a string holds {escaped[0]}, where the App ends it: choose the other quotation "
                "mark, or '\\x27' for it"
            )
        for name, value in self.private().items():
            if re.match(r"(OperatableStateMachine|\w+Container)\(", value):
                raise AppLoadError(f"the definition of container {name} is not read: {value}")
        returned = _RETURNED.search(self._text)
        return self._container(returned[1] if returned else "", "", ())

    def _container(self, variable: str, path: str, above: tuple[str, ...]) -> Container:
        definition, block = self._definitions[variable], self._blocks.get(variable, "")
        if not definition.places:
            self._lost.append(f"the App loses the positions of the outcomes of '{path or '/'}'")
        if len(re.findall(r"\.add\(", block)) != len(_ADD.findall(block)):
            self._lost.append(
                f"the App loses an add in '{path or '/'}' that is not OperatableStateMachine.add"
            )
        adds = [
            self._child(found, block, path, (*above, variable)) for found in _ADD.finditer(block)
        ]
        labels = {child.label for child in adds} | set(definition.outcomes)
        return replace(
            definition, children=tuple(self._connected(child, labels, path) for child in adds)
        )

    def _child(self, found: re.Match[str], block: str, path: str, above: tuple[str, ...]) -> Child:
        arguments = cut.items(cut.bracketed(block, found.end() - 1) or "")
        label = cut.unquoted(arguments[0]) if arguments else None
        if label is None or len(arguments) < 2:
            raise AppLoadError(f"a call of add in '{path or '/'}' is not read")
        inner = f"{path}/{label}"
        if found[1] is None:
            self._lost.append(f"the App loses the position of '{inner}'")
        maps = {name: self._map(name, arguments[2:], inner) for name in _MAPS}
        internal = {name: value.strip() for name, value in _INTERNAL.findall(found[3] or "")}
        content = self._content(
            arguments[1], inner, above, (*maps["transitions"],), internal=internal
        )
        place: Point = _DEFAULT_PLACE if found[1] is None else (int(found[1]), int(found[2]))
        return Child(label, place, content, *(maps[name] for name in _MAPS))

    def _map(self, name: str, arguments: list[str], path: str) -> dict[str, str]:
        """Return what an argument maps to what; names without their quotes."""
        for argument in arguments:
            found = re.match(rf"{name}\s*=\s*\{{([^{{}}]*)\}}\Z", argument)
            if found:
                entries = cut.pairs(found[1])
                return {key: cut.unquoted(v) or v for key, v in entries.items()}
            if argument.startswith(name):
                self._lost.append(
                    f"the App loses {name} of '{path}', which are not read: {argument}"
                )
        return {}

    def _content(
        self,
        text: str,
        path: str,
        above: tuple[str, ...],
        used: tuple[str, ...],
        internal: dict[str, str],
    ) -> StateUse | BehaviorUse | Container:
        if text in above:
            raise AppLoadError(f"'{path}' contains itself")
        if text in self._definitions:
            return self._container(text, path, above)
        called = re.match(r"([\w.]+)\(", text)
        if called is None:
            raise AppLoadError(f"'{path}' is neither a state, a behavior nor a container: {text}")
        inside = cut.bracketed(text, called.end() - 1) or ""
        if called[1] == "self.use_behavior":
            return self._behavior(cut.items(inside), path)
        return self._state(called[1], cut.parts(inside), path, used, internal=internal)

    def _state(
        self,
        alias: str,
        arguments: list[str],
        path: str,
        used: tuple[str, ...],
        internal: dict[str, str],
    ) -> StateUse:
        definition = self._known.state(alias, [without_blanks(outcome) for outcome in used])
        if definition is None:
            raise AppLoadError(f"'{path}' is of the class {alias}, which the App does not know")
        given = dict(internal)
        # What has no name is for the first parameters: also nothing, as between `()`.
        nameless = [each for each in arguments if not re.match(r"\w+\s*=[^=]", each)]
        for argument in arguments:
            keyword = re.match(r"(\w+)\s*=\s*([^=].*)", argument, re.DOTALL)
            if keyword and keyword[1] in definition.parameters:
                given[keyword[1]] = keyword[2]
            elif keyword:
                self._lost.append(
                    f"the App loses parameter {keyword[1]} of '{path}', which {alias} hides"
                )
        ordinary = [name for name in definition.parameters if not name.startswith("?")]
        given |= dict(zip(ordinary, nameless, strict=False))
        return StateUse(definition, given)

    def _behavior(self, arguments: list[str], path: str) -> BehaviorUse:
        definition = self._known.behavior(arguments[0]) if arguments else None
        if definition is None or len(arguments) < 2:
            raise AppLoadError(f"'{path}' is a behavior that the App does not know: {arguments}")
        keys: tuple[str, ...] = ()
        given: dict[str, str] = {}
        for argument in arguments[2:]:
            keyword, _, value = argument.partition("=")
            if keyword == "default_keys":
                keys = tuple(cut.names(value) or ())
            elif re.fullmatch(r"\{[^{})]*\}", value):
                given = cut.pairs(value[1:-1])
            else:
                self._lost.append(
                    f"the App loses parameters of '{path}', with a brace or ')' in them: {value}"
                )
        return BehaviorUse(definition, cut.unquoted(arguments[1]) or "", keys, given)

    def _connected(self, child: Child, targets: set[str], path: str) -> Child:
        """Return a child without the transitions that the App cannot connect."""
        kept, inner = {}, f"{path}/{child.label}"
        for outcome, target in child.transitions.items():
            if outcome not in child.content.outcomes:
                why = (
                    "the App drops the blanks of a state's outcomes"
                    if without_blanks(outcome) in child.content.outcomes
                    else f"its outcomes are {', '.join(child.content.outcomes) or 'none'}"
                )
                self._lost.append(
                    f"the App loses the transition of '{outcome}' of '{inner}': {why}"
                )
            elif target not in targets:
                self._lost.append(
                    f"the App loses the transition of '{outcome}' of '{inner}' to '{target}'"
                )
            else:
                kept[outcome] = target
        for key in child.remapping:
            if key not in child.keys:
                self._lost.append(
                    f"the App loses the remapping of '{key}' of '{inner}', which it does not have"
                )
        homes = {key: child.remapping.get(key, key) for key in child.keys}
        return replace(child, transitions=kept, remapping=homes)


def _definition(found: re.Match[str]) -> Container:
    """Return a container without its content."""
    lists = {}
    for argument in cut.items(found[4]):
        keyword, _, value = argument.partition("=")
        listed = cut.names(value)
        if listed is None:
            raise AppLoadError(
                f"{found[2]} has an argument that is not a list of names: {argument}"
            )
        lists[keyword.strip()] = tuple(listed)
    conditions = _conditions(found) if found.re is _CONCURRENT else ()
    places = re.findall(r"x:(-?\d+) y:(-?\d+)", found[1] or "")
    return Container(
        found[3],
        lists.get("outcomes", ()),
        lists.get("input_keys", ()),
        lists.get("output_keys", ()),
        places=tuple((int(x), int(y)) for x, y in places),
        conditions=conditions,
    )


def _conditions(found: re.Match[str]) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
    """Return the conditions of a concurrency container."""
    unread = _CONDITION.sub("", found[5]).replace(",", "").strip()
    if unread:
        raise AppLoadError(f"{found[2]} has a condition that is not read: {unread}")
    read = _CONDITION.findall(found[5])
    return tuple((outcome, tuple(_PAIR.findall(pairs))) for outcome, pairs in read)
