"""A behavior and its states as the FlexBE App reads them, by patterns in source text.

The App does not read files as Python, so a file that runs may still lose parts there. Written from
observations of the running App, version 2.3.0; where they leave room, the stricter reading is
taken.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

_OPEN, _CLOSE = "([{", ")]}"
_QUOTED = re.compile(r"\s*(?:'([^']*)'|\"([^\"]*)\")\s*\Z")
_TOKEN = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"|[\[\](){},'\"]", re.DOTALL)
MANUAL_TAGS = ("IMPORT", "INIT", "CREATE", "FUNC")


class AppLoadError(ValueError):
    """The App cannot load the file."""


def manual_sections(text: str) -> dict[str, str]:
    """Return the text between the tags of each manual section, '' for one without tags.

    Raises:
        AppLoadError: if a section begins and does not end exactly once after that.
    """
    found = {}
    for tag in MANUAL_TAGS:
        begin, end = f"# [MANUAL_{tag}]", f"# [/MANUAL_{tag}]"
        if text.count(begin) != 1:
            found[tag] = ""  # without tags, or with several, nothing is extracted
            continue
        rest = text.partition(begin)[2]
        if rest.count(end) != 1:
            raise AppLoadError(f"'{begin}' is not followed by exactly one '{end}'")
        found[tag] = rest.partition(end)[0]
    return found


def without_manual(text: str) -> str:
    """Return the text without what stands in manual sections."""
    for tag in MANUAL_TAGS:
        begin, end = f"# [MANUAL_{tag}]", f"# [/MANUAL_{tag}]"
        if text.count(begin) == 1:
            head, _, rest = text.partition(begin)
            text = f"{head}{begin}{end}{rest.partition(end)[2]}"
    return text


def section(text: str, head: str) -> str:
    """Return a method's text: up to the next ` def `, even in a comment."""
    rest = text.partition(head)[2]
    end = re.search(r"\sdef\s", rest)
    return rest[: end.start()] if end else rest


def bracketed(text: str, start: int) -> str | None:
    """Return what stands between the bracket at `start` and its partner; None without one."""
    depth = 0
    for place, mark in _marks(text, start):
        depth += (mark in _OPEN) - (mark in _CLOSE)
        if depth == 0:
            return text[start + 1 : place]
    return None


def items(text: str) -> list[str]:
    """Return the parts between commas outside of brackets and quotes, but for empty ones."""
    return [part for part in parts(text) if part]


def parts(text: str) -> list[str]:
    """Return the parts between commas outside of brackets and quotes, without outer blanks.

    What is empty is one empty part, and so is what follows a trailing comma.
    """
    cuts, depth = [-1], 0
    for place, mark in _marks(text):
        depth += (mark in _OPEN) - (mark in _CLOSE)
        if mark == "," and depth == 0:
            cuts.append(place)
    cuts.append(len(text))
    return [text[a + 1 : b].strip() for a, b in itertools.pairwise(cuts)]


def unquoted(text: str) -> str | None:
    """Return the text of a quoted string, None for anything else."""
    found = _QUOTED.match(text)
    return None if found is None else found[1] if found[1] is not None else found[2]


def names(text: str) -> list[str] | None:
    """Return the strings of a list `['a', "b"]`, None for anything else."""
    inner = re.fullmatch(r"\s*\[(.*)\]\s*", text, re.DOTALL)
    if inner is None:
        return None
    found = [unquoted(item) for item in items(inner[1])]
    return None if None in found else [name for name in found if name is not None]


def pairs(text: str) -> dict[str, str]:
    """Return the entries of `'key': value, ...`; those whose key is not quoted are left out."""
    found = {}
    for item in items(text):
        entry = re.match(r"('[^']*'|\"[^\"]*\")\s*:\s*(.*)", item, re.DOTALL)
        if entry:
            found[entry[1][1:-1]] = entry[2].strip()
    return found


def _marks(text: str, start: int = 0) -> Iterator[tuple[int, str]]:
    """Yield place and letter of brackets and commas outside of quotes, and of quotes left open."""
    for found in _TOKEN.finditer(text, start):
        if len(found[0]) == 1:
            yield found.start(), found[0]


_CLASS = re.compile(r"^\s*class\s+(\w+)\s*\(EventState\)\s*:", re.MULTILINE)
_PARAMETERS = re.compile(r"\bdef __init__\(self, ([^)\n]+)\):")
_LISTS = ("outcomes", "input_keys", "output_keys")


@dataclass(frozen=True)
class FromParameter:
    """A list of names that comes from the value of a parameter; a `?` begins an artificial one."""

    parameter: str


Names = tuple[str, ...] | FromParameter


@dataclass(frozen=True)
class StateDefinition:
    """What the App knows of a state class.

    Attributes:
        module: where behaviors import it from.
        parameters: default of each parameter as text; None if it has none.
        outcomes: without blanks, which the App drops.
        spellings: each outcome as the file spells it, by the App's name of it.
    """

    class_name: str
    package: str
    module: str
    parameters: dict[str, str | None]
    outcomes: Names = ()
    input_keys: Names = ()
    output_keys: Names = ()
    spellings: dict[str, str] = field(default_factory=dict)


def read_state(text: str, module: str) -> StateDefinition | None:
    """Return the first state of a file, None if the App sees none."""
    found = _CLASS.search(text)
    if found is None:
        return None
    body = text[found.end() :]
    given = _PARAMETERS.search(body)
    parameters = dict(map(_parameter, items(given[1]))) if given else {}
    lists: dict[str, Names] = {}
    spellings: dict[str, str] = {}
    for keyword, value in _super_arguments(body).items():
        if keyword in _LISTS:
            lists[keyword] = _names(keyword, value, parameters)
            if keyword == "outcomes":
                spellings = {without_blanks(name): name for name in names(value) or ()}
    parameters |= {
        listed.parameter: None
        for listed in lists.values()
        if isinstance(listed, FromParameter) and listed.parameter not in parameters
    }
    package = module.partition(".")[0]
    return StateDefinition(found[1], package, module, parameters, spellings=spellings, **lists)


def without_blanks(outcome: str) -> str:
    """Return an outcome as the App reads it from a list of outcomes."""
    return re.sub(r"\s", "", outcome)


def _parameter(text: str) -> tuple[str, str | None]:
    """Return name and default; an annotation counts as part of the name, as in the App."""
    name, equals, default = text.partition("=")
    return name.strip(), re.sub(r"\s", "", default) if equals else None


def _super_arguments(body: str) -> dict[str, str]:
    call = re.search(r"\bsuper\([^)]*\)\.__init__\(", body)
    inner = call and bracketed(body, call.end() - 1)
    return dict(_keyword(item) for item in items(inner or "") if "=" in item)


def _keyword(item: str) -> tuple[str, str]:
    name, _, value = item.partition("=")
    return name.strip(), value.strip()


def _names(keyword: str, value: str, parameters: dict[str, str | None]) -> Names:
    listed = names(value)
    if listed is not None:
        return tuple(without_blanks(n) if keyword == "outcomes" else n for n in listed)
    return FromParameter(value if value in parameters else f"?{keyword}")


# Whether the App sees all of a state class


_BASE = "EventState"


def judge_state(text: str, module: str) -> list[str]:
    """Return what the App does not see of the states in a file, each with its line.

    Args:
        text: the file.
        module: where behaviors import it from.

    Raises:
        SyntaxError: if it is not Python.
    """
    seen = read_state(text, module)
    states = [
        node
        for node in ast.parse(text).body
        if isinstance(node, ast.ClassDef) and _BASE in map(ast.unparse, node.bases)
    ]
    return [
        f"line {line}: the App {what}" for state in states for line, what in _hidden(state, seen)
    ]


def _hidden(state: ast.ClassDef, seen: StateDefinition | None) -> Iterator[tuple[int, str]]:
    """Yield line and text of each part that the App does not see."""
    if seen is None or seen.class_name != state.name:
        why = f"is not the first class of its file with the base list ({_BASE})"
        yield state.lineno, f"does not see {state.name}, which {why}"
        return
    init = next((n for n in state.body if getattr(n, "name", "") == "__init__"), None)
    if not isinstance(init, ast.FunctionDef):
        yield state.lineno, f"sees no outcome of {state.name}, which has no __init__"
        return
    arguments = [a.arg for a in (*init.args.posonlyargs, *init.args.args, *init.args.kwonlyargs)]
    hidden = [name for name in arguments[1:] if name not in seen.parameters]
    if hidden:
        yield (
            init.lineno,
            f"does not see the arguments {', '.join(hidden)} of {state.name}: all must follow "
            "'def __init__(self, ' on one line, without annotations and inner ')'",
        )
    for name in seen.parameters:
        if name.startswith("?"):
            yield (
                init.lineno,
                f"cannot read the {name[1:]} of {state.name}: they are not a plain list",
            )
    if not seen.outcomes:
        yield init.lineno, f"sees no outcome of {state.name}"
    if any(isinstance(node, ast.keyword) and node.arg == "io_keys" for node in ast.walk(init)):
        yield init.lineno, f"does not see io_keys of {state.name}: list them as input and output"
    for name in () if isinstance(seen.outcomes, FromParameter) else seen.outcomes:
        if seen.spellings.get(name, name) != name:
            yield (
                init.lineno,
                f"reads outcome '{seen.spellings[name]}' of {state.name} as '{name}'",
            )


Point = tuple[int, int]


@dataclass(frozen=True)
class BehaviorDefinition:
    """What the App knows of a behavior that others can contain."""

    name: str
    class_name: str
    module: str
    outcomes: tuple[str, ...] = ()
    input_keys: tuple[str, ...] = ()
    output_keys: tuple[str, ...] = ()


@dataclass(frozen=True)
class StateUse:
    """A state with the values of its parameters that its call gives, as text by name."""

    definition: StateDefinition
    given: Mapping[str, str]

    def value(self, parameter: str) -> str:
        """Return a value, given or default; empty if there is none, or if an empty one is given."""
        return self.given.get(parameter, self.definition.parameters.get(parameter) or "")

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the outcomes, without blanks."""
        return tuple(map(without_blanks, self._names(self.definition.outcomes)))

    @property
    def input_keys(self) -> tuple[str, ...]:
        """Return the keys that it reads."""
        return self._names(self.definition.input_keys)

    @property
    def output_keys(self) -> tuple[str, ...]:
        """Return the keys that it writes."""
        return self._names(self.definition.output_keys)

    def _names(self, declared: Names) -> tuple[str, ...]:
        if isinstance(declared, FromParameter):
            return tuple(names(self.value(declared.parameter)) or ())
        return declared


@dataclass(frozen=True)
class BehaviorUse:
    """A contained behavior; `keys_by_default` are inputs that keep their own default."""

    definition: BehaviorDefinition
    id: str
    keys_by_default: tuple[str, ...] = ()
    given: Mapping[str, str] = field(default_factory=dict)

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the outcomes."""
        return self.definition.outcomes

    @property
    def input_keys(self) -> tuple[str, ...]:
        """Return the keys that must be fed."""
        return tuple(k for k in self.definition.input_keys if k not in self.keys_by_default)

    @property
    def output_keys(self) -> tuple[str, ...]:
        """Return the keys that it writes."""
        return self.definition.output_keys


@dataclass(frozen=True)
class Container:
    """A container of states; `kind` is the class that the file constructs."""

    kind: str
    outcomes: tuple[str, ...]
    input_keys: tuple[str, ...]
    output_keys: tuple[str, ...]
    places: tuple[Point, ...]
    conditions: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()
    children: tuple[Child, ...] = ()


@dataclass(frozen=True)
class Child:
    """A state, behavior or container in a container."""

    label: str
    place: Point
    content: StateUse | BehaviorUse | Container
    transitions: Mapping[str, str]
    autonomy: Mapping[str, str]
    remapping: Mapping[str, str]

    @property
    def keys(self) -> tuple[str, ...]:
        """Return all keys, inputs first."""
        return tuple(dict.fromkeys((*self.content.input_keys, *self.content.output_keys)))


# The states and behaviors that the App knows, and which of them a name means


class Known:
    """What the App found in the packages of a workspace."""

    def __init__(
        self,
        states: Iterable[StateDefinition] = (),
        behaviors: Iterable[BehaviorDefinition] = (),
    ) -> None:
        self.states = tuple(states)
        self.behaviors = tuple(behaviors)

    def behavior(self, class_name: str) -> BehaviorDefinition | None:
        """Return the behavior of a class."""
        return next((b for b in self.behaviors if b.class_name == class_name), None)

    def state(self, alias: str, used: Collection[str]) -> StateDefinition | None:
        """Return the state of a name in a file: `Class`, or `package__Class`.

        Args:
            alias: the name.
            used: outcomes, without blanks, which distinguish states of one class name.
        """
        package, separator, name = alias.partition("__")
        if separator:
            found = [s for s in self.states if (s.package, s.class_name) == (package, name)]
            return found[0] if found else None
        found = [s for s in self.states if s.class_name == alias]
        covering = [s for s in found if _covers(s, used)] if len(found) > 1 else found
        return covering[0] if covering else None


def _covers(state: StateDefinition, used: Collection[str]) -> bool:
    return isinstance(state.outcomes, FromParameter) or set(used) <= set(state.outcomes)
