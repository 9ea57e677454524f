"""Whether a behavior can be loaded, checked and saved by the App, and is the same afterwards."""

from __future__ import annotations

import ast
import difflib
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

from flexbe_testing.core import app_load
from flexbe_testing.core.app_behavior import (
    AppLoadError,
    BehaviorUse,
    Child,
    Container,
    Known,
    StateDefinition,
    StateUse,
    _marks,
    manual_sections,
    section,
    without_manual,
)

_SHOWN = 6  # changed lines that a complaint shows
_PARAMETER = re.compile(r"self\.add_parameter\(['\"](\w+)['\"], (.*)\)[ \t]*$", re.MULTILINE)
_USERDATA = re.compile(r"^[ \t]*\w+\.userdata\.(\w+) = (.*)$", re.MULTILINE)
_BRACKETS = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class AppBehavior:
    """A loaded behavior."""

    name: str
    class_name: str
    description: str
    author: str
    date: str
    parameters: Mapping[str, str]
    notes: str
    private: Mapping[str, str]
    userdata: Mapping[str, str]
    manual: Mapping[str, str]
    root: Container
    lost: tuple[str, ...]


def load(text: str, known: Known) -> AppBehavior:
    """Return all that the App takes from a behavior's file.

    Raises:
        AppLoadError: if the App cannot load it.
    """
    root, lost = app_load.load_behavior(text, known)
    read = without_manual(text)
    init, create = section(read, app_load._INIT), section(read, app_load._CREATE)
    created, description = app_load._CREATED.search(read), app_load._DESCRIPTION.search(read)
    notes = (line.strip() for line in init.partition(app_load._COMMENTS)[2].splitlines())
    return AppBehavior(
        name=app_load._NAME.search(init)[1],
        class_name=app_load._class_name(read),
        description=description[1].strip() if description else "",
        author=created[2] if created else "",
        date=created[1] if created else "",
        parameters=dict(_PARAMETER.findall(init)),
        notes="\n".join(line for line in notes if line),
        private=app_load.CreateSection(create, known, []).private(),
        userdata=dict(_USERDATA.findall(create)),
        manual=manual_sections(text),
        root=root,
        lost=lost,
    )


def walk(container: Container, path: str = "") -> Iterator[tuple[str, Child]]:
    """Yield all children with their paths, those of a container after it."""
    for child in container.children:
        inner = f"{path}/{child.label}"
        yield inner, child
        if isinstance(child.content, Container):
            yield from walk(child.content, inner)


def alias(known: Known, state: StateDefinition) -> str:
    """Return the name that the App gives to a state when it saves a behavior."""
    of_this_name = [s for s in known.states if s.class_name == state.class_name]
    is_unique = len(of_this_name) == 1
    return state.class_name if is_unique else f"{state.package}__{state.class_name}"


def _is_concurrent(container: Container) -> bool:
    return container.kind == "ConcurrencyContainer"


def _is_balanced(text: str) -> bool:
    """Return whether all brackets and quotes of a value close."""
    open_ones = []
    for _place, mark in _marks(text):
        if mark in _BRACKETS:
            open_ones.append(_BRACKETS[mark])
        elif mark != "," and (not open_ones or open_ones.pop() != mark):
            return False
    return not open_ones


def _level(child: Child, outcome: str) -> str:
    """Return the autonomy that an outcome needs."""
    inherit = "Autonomy.Inherit"
    default = "Autonomy.Off" if isinstance(child.content, StateUse) else inherit
    level = child.autonomy.get(outcome, default)
    is_level = re.fullmatch(r"Autonomy\.(Off|Low|High|Full|Inherit)|-?\d+", level)
    return level if is_level else inherit


def judge(text: str, known: Known) -> list[str]:
    """Return what keeps the App from loading and saving a behavior without a change.

    Args:
        text: the behavior's file.
        known: the states and behaviors of the workspace.
    """
    try:
        behavior = load(text, known)
    except AppLoadError as error:
        return [f"the App cannot load it: {error}"]
    complaints = list(behavior.lost)
    complaints += [f"the App does not save it: {why}" for why in check_behavior(behavior)]
    if behavior.class_name != behavior_class(behavior.name):
        complaints.append(f"the App saves it as class {behavior_class(behavior.name)}")
    if complaints:
        return complaints
    try:
        complaints += _changes(text, save_behavior(behavior, known, with_defaults=False), known)
        saved = save_behavior(behavior, known)
        if save_behavior(load(saved, known), known) != saved:
            complaints.append("what the App saves, it loads as something else")
    except (AppLoadError, SyntaxError) as error:
        complaints.append(f"the App saves what cannot be read: {error}")
    return complaints


def saved_by_app(text: str, known: Known) -> str:
    """Return the file that the App makes of a behavior's file.

    Raises:
        AppLoadError: if the App cannot load it.
    """
    return save_behavior(load(text, known), known)


def _changes(text: str, saved: str, known: Known) -> Iterator[str]:
    """Yield a complaint if the code is not the same, comments left out."""
    parameters = {f"{s.module}.{s.class_name}": list(s.parameters) for s in known.states}
    before, after = (_code_lines(source, parameters) for source in (text, saved))
    changed = [line for line in difflib.ndiff(before, after) if line[0] in "+-"]
    if changed:
        shown = "\n".join(f"    {line}" for line in changed[:_SHOWN])
        yield f"saving changes the code:\n{shown}"


def _code_lines(source: str, parameters: Mapping[str, list[str]]) -> list[str]:
    """Return the statements, without what differs though it means the same.

    That is the order of keyword arguments, a state's arguments without keyword (`parameters` has
    the names by the state's module and class), the blanks of a docstring, and the names under which
    classes are imported: the App renames states when another package has one of the same name. So
    the imports are left out, and each imported name has its module before it.
    """
    tree = ast.parse(source)
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    aliases = {n.asname or n.name: f"{i.module}.{n.name}" for i in imports for n in i.names}
    tree.body = [node for node in tree.body if node not in imports]
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            named = parameters.get(aliases.get(getattr(node.func, "id", ""), ""), [])
            nameless = node.args[: len(named)]
            node.keywords += [ast.keyword(n, v) for n, v in zip(named, nameless, strict=False)]
            del node.args[: len(named)]
            node.keywords.sort(key=lambda keyword: keyword.arg or "")
        elif isinstance(node, ast.Name):
            node.id = aliases.get(node.id, node.id)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            node.value.value = " ".join(str(node.value.value).split())
    return ast.unparse(tree).splitlines()


# What the App demands of a behavior before it saves it


def check_behavior(behavior: AppBehavior) -> Iterator[str]:
    """Yield why the App refuses to save a behavior."""
    for what in ("name", "description", "author"):
        if not getattr(behavior, what):
            yield f"the behavior has no {what}"
    for key in dict.fromkeys((*behavior.root.input_keys, *behavior.root.output_keys)):
        if key not in behavior.userdata:
            yield f"no default userdata for the key '{key}' of the interface"
    yield from _check_container(behavior.root, "", behavior.userdata)


def _check_container(container: Container, path: str, available: Collection[str]) -> Iterator[str]:
    title = path or "/"
    if not container.outcomes:
        yield f"container '{title}' has no outcomes"
    if not container.children:
        yield f"container '{title}' has no states"
    for label, count in Counter(child.label for child in container.children).items():
        if count > 1 or label in container.outcomes:
            yield f"'{label}' in '{title}' is used more than once there"
    writers = _writers_before(container)
    for child in container.children:
        inner = f"{path}/{child.label}"
        yield from _check_child(child, inner)
        written = {home for other in writers[child.label] for home in _written(other)}
        for key in child.content.input_keys:
            home = child.remapping[key]
            if home not in written and home not in available:
                yield f"input '{key}' of '{inner}': nothing before it writes '{home}'"
        if isinstance(child.content, Container):
            yield from _check_container(child.content, inner, child.content.input_keys)
    if _is_concurrent(container):
        yield from _check_conditions(container, title)


def _check_child(child: Child, path: str) -> Iterator[str]:
    if not child.content.outcomes:
        yield f"'{path}' has no outcomes that the App can read"
    for outcome in child.content.outcomes:
        if outcome not in child.transitions:
            yield f"outcome '{outcome}' of '{path}' is not connected"
    for key in (*child.remapping, *child.remapping.values()):
        if not key.isidentifier():
            yield f"the key '{key}' of '{path}' is not an identifier"
    if isinstance(child.content, StateUse):
        for name in child.content.definition.parameters:
            value = child.content.value(name)
            if not value:
                yield (
                    f"parameter '{name}' of '{path}' is empty: the App takes `()`, and what "
                    "follows a trailing comma, for an empty first value; give one by name"
                )
            elif not _is_balanced(value):
                yield (
                    f"parameter '{name}' of '{path}' has a bracket or quote that does not close: "
                    f"{value}"
                )
    elif isinstance(child.content, Container) and not _variable_part(child.label).isidentifier():
        yield (
            f"it would name a variable '{_variable_part(child.label)}_0' after container "
            f"'{path}', which is not Python"
        )


def _variable_part(label: str) -> str:
    return "_sm_" + label.lower().replace(" ", "_")


def _check_conditions(container: Container, title: str) -> Iterator[str]:
    listed = [pair for _outcome, pairs in container.conditions for pair in pairs]
    for pair, count in Counter(listed).items():
        if count > 1:
            yield f"outcome '{pair[1]}' of '{title}/{pair[0]}' is in two conditions"
    for _outcome, pairs in container.conditions:
        states = [state for state, _ in pairs]
        if len(set(states)) < len(states):
            yield f"a condition of '{title}' has two outcomes of one state"
    leads_to = {pair: outcome for outcome, pairs in container.conditions for pair in pairs}
    for child in container.children:
        for outcome, target in child.transitions.items():
            if leads_to.get((child.label, outcome)) != target:
                yield (
                    f"outcome '{outcome}' of '{title}/{child.label}' leads to '{target}', and its "
                    f"condition to '{leads_to.get((child.label, outcome))}'"
                )


def _written(child: Child) -> Iterator[str]:
    return (child.remapping[key] for key in child.content.output_keys)


def _writers_before(container: Container) -> Mapping[str, tuple[Child, ...]]:
    """Return, by label, all children from which transitions lead to one."""
    by_label = {child.label: child for child in container.children}
    before: dict[str, set[str]] = {label: set() for label in by_label}
    if not _is_concurrent(container):
        for child in container.children:
            for target in child.transitions.values():
                before.get(target, set()).add(child.label)
    found = {}
    for label in by_label:
        reached, left = set(before[label]), list(before[label])
        while left:
            new = before[left.pop()] - reached
            reached |= new
            left += new
        found[label] = tuple(by_label[other] for other in reached)
    return found


# Save a behavior as the App does


_INDENT = " " * 4
_LINE = "\n" + _INDENT * 3
_MORE = "\n" + _INDENT * 10
_ROOT = "_state_machine"
_FILE = """\
#!/usr/bin/env python3
# -*- coding: utf-8 -*-

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, \
PriorityContainer, Logger
{imports}
# [MANUAL_IMPORT]{IMPORT}# [/MANUAL_IMPORT]


'''
Created on {date}
@author: {author}
'''
class {class_name}(Behavior):
    '''
    {description}
    '''


    def __init__(self):
        super({class_name}, self).__init__()
        self.name = '{name}'
{constructed}
        # [MANUAL_INIT]{INIT}# [/MANUAL_INIT]

        # Behavior comments:
{notes}


    def create(self):
{created}
        # [MANUAL_CREATE]{CREATE}# [/MANUAL_CREATE]

{blocks}
        return _state_machine


    # [MANUAL_FUNC]{FUNC}# [/MANUAL_FUNC]
"""


def behavior_class(name: str) -> str:
    """Return the class under which the App saves a behavior of this name."""
    return re.sub(r"\W", "", name, flags=re.ASCII) + "SM"


def behavior_module(name: str) -> str:
    """Return the module under which the App saves a behavior of this name."""
    return re.sub(r"\W", "_", name.lower(), flags=re.ASCII) + "_sm"


def save_behavior(behavior: AppBehavior, known: Known, with_defaults: bool = True) -> str:
    """Return the file that the App writes; comments that guide the reader are left out.

    The App writes all parameters of a state. Without defaults, those that the file gave are
    written, to compare the two.
    """
    inner = {
        path: child.content
        for path, child in walk(behavior.root)
        if isinstance(child.content, Container)
    }
    writer = _Writer(known, _variables(inner), with_defaults)
    blocks = [
        writer.definition(path, inner[path]) + "\n\n" + writer.block(path, inner[path]) + "\n\n"
        for path in sorted(inner, reverse=True)
    ]
    create = [f"{name} = {value}" for name, value in behavior.private.items()]
    create.append(writer.definition("", behavior.root).lstrip())
    create += [f"{_ROOT}.userdata.{key} = {value}" for key, value in behavior.userdata.items()]
    return _FILE.format(
        imports="\n".join(writer.imports(behavior.root)),
        date=behavior.date,
        author=behavior.author,
        class_name=behavior_class(behavior.name),
        description=behavior.description,
        name=behavior.name,
        constructed="".join(f"{_INDENT * 2}{line}\n" for line in _constructed(behavior)),
        notes="".join(f"{_INDENT * 2}{line}\n" for line in behavior.notes.splitlines()),
        created="".join(f"{_INDENT * 2}{line}\n" for line in create),
        blocks="\n".join([*blocks, writer.block("", behavior.root) + "\n\n"]),
        **behavior.manual,
    )


def _constructed(behavior: AppBehavior) -> Iterable[str]:
    """Yield the statements that declare parameters and contained behaviors."""
    for name, default in behavior.parameters.items():
        yield f"self.add_parameter('{name}', {default})"
    for path, child in sorted(walk(behavior.root), key=lambda found: found[0]):
        if isinstance(child.content, BehaviorUse):
            yield f"self.add_behavior({child.content.definition.class_name}, '{path[1:]}')"


def _variables(inner: Mapping[str, Container]) -> dict[str, str]:
    """Return the variable of each container."""
    found = {"": _ROOT}
    for number, path in enumerate(sorted(inner, reverse=True)):
        label = path.rpartition("/")[2].lower().replace(" ", "_")
        found[path] = f"_sm_{label}_{number}"
    return found


class _Writer:
    """Writes containers and what they hold."""

    def __init__(self, known: Known, variables: Mapping[str, str], with_defaults: bool) -> None:
        self._known = known
        self._variables = variables
        self._with_defaults = with_defaults

    def imports(self, root: Container) -> list[str]:
        found = set()
        for _path, child in walk(root):
            content = child.content
            if isinstance(content, StateUse):
                definition = content.definition
                name, as_name = definition.class_name, alias(self._known, definition)
                line = f"from {definition.module} import {name}"
                found.add(line if name == as_name else f"{line} as {as_name}")
            elif isinstance(content, BehaviorUse):
                definition = content.definition
                found.add(f"from {definition.module} import {definition.class_name}")
        return sorted(found)

    def definition(self, path: str, container: Container) -> str:
        lists = {
            "outcomes": container.outcomes,
            "input_keys": container.input_keys,
            "output_keys": container.output_keys,
        }
        given = [f"{k}={_names(v)}" for k, v in lists.items() if v or k == "outcomes"]
        if _is_concurrent(container):
            conditions = f",{_MORE}".join(map(_condition, container.conditions))
            given.append(f"conditions=[{_MORE}{conditions}{_MORE}]")
        places = ", ".join(f"x:{x} y:{y}" for x, y in container.places)
        indent = _INDENT * 2
        return (
            f"{indent}# {places}\n"
            f"{indent}{self._variables[path]} = {container.kind}({', '.join(given)})"
        )

    def block(self, path: str, container: Container) -> str:
        adds = [self._add(f"{path}/{c.label}", c) for c in _in_order(container.children)]
        between = "\n" + _LINE
        return f"{_INDENT * 2}with {self._variables[path]}:{_LINE}{between.join(adds)}"

    def _add(self, path: str, child: Child) -> str:
        outcomes = child.content.outcomes
        targets = [f"'{o}': '{child.transitions[o]}'" for o in outcomes if o in child.transitions]
        levels = [f"'{outcome}': {_level(child, outcome)}" for outcome in outcomes]
        homes = [f"'{key}': '{child.remapping[key]}'" for key in child.keys]
        (x, y), content = child.place, child.content
        internal = {}
        if isinstance(content, StateUse):
            internal = {name: v for name, v in content.given.items() if name.startswith("?")}
        comment = ",".join(f"{name} = {value}" for name, value in internal.items())
        remapping = f",{_MORE}remapping={{{', '.join(homes)}}}" if homes else ""
        return (
            f"# x:{x} y:{y}{f' {{{comment}}}' if comment else ''}{_LINE}"
            f"OperatableStateMachine.add('{child.label}',{_MORE}{self._content(path, content)},"
            f"{_MORE}transitions={{{', '.join(targets)}}},{_MORE}autonomy={{{', '.join(levels)}}}"
            f"{remapping})"
        )

    def _content(self, path: str, content: StateUse | BehaviorUse | Container) -> str:
        if isinstance(content, Container):
            return self._variables[path]
        if isinstance(content, StateUse):
            given = [
                f"{name}={content.value(name)}"
                for name in content.definition.parameters
                if not name.startswith("?") and (self._with_defaults or name in content.given)
            ]
            return f"{alias(self._known, content.definition)}({', '.join(given)})"
        parts = [content.definition.class_name, f"'{path[1:]}'"]
        if content.keys_by_default:
            parts.append(f"default_keys={_names(content.keys_by_default)}")
        if content.given:
            given = [f"'{name}': {value}" for name, value in content.given.items()]
            parts.append(f"parameters={{{', '.join(given)}}}")
        return f"self.use_behavior({', '.join(parts)})"


def _names(listed: Iterable[str]) -> str:
    return "[" + ", ".join(f"'{name}'" for name in listed) + "]"


def _condition(condition: tuple[str, tuple[tuple[str, str], ...]]) -> str:
    outcome, pairs = condition
    listed = ", ".join(f"('{state}', '{ends}')" for state, ends in pairs)
    return f"('{outcome}', [{listed}])"


def _in_order(children: tuple[Child, ...]) -> list[Child]:
    """Return the initial child, then the others by label, of which the first goes to the end.

    The first of all labels stays where it is only if it is the initial one.
    """
    ordered = sorted(children, key=lambda child: child.label)
    if not ordered:
        return ordered
    initial = children[0]
    if ordered[0] is not initial:
        ordered.append(ordered.pop(0))
    ordered.remove(initial)
    return [initial, *ordered]


# A behavior's manifest, as the App demands it


_DEMANDED = ("author", "description")


def judge_manifest(manifest: str, text: str, known: Known) -> list[str]:
    """Return why the App does not read a manifest, or saves it as something else.

    Args:
        manifest: its text.
        text: the behavior's file.
        known: the states and behaviors of the workspace.
    """
    try:
        root = ElementTree.fromstring(manifest.encode())
        return list(_complaints(root, text, known))
    except (ElementTree.ParseError, AppLoadError) as error:
        return [f"the App cannot read it: {error}"]


def _complaints(root: ElementTree.Element, text: str, known: Known) -> Iterator[str]:
    executables = list(root.iter("executable"))
    if root.tag != "behavior" or len(list(root.iter("behavior"))) != 1 or len(executables) != 1:
        yield "not exactly one <behavior> with one <executable>"
        return
    name, path = root.get("name", ""), executables[0].get("package_path", "")
    package, _, module = path.partition(".")
    if (module, executables[0].get("class")) != (behavior_module(name), behavior_class(name)):
        yield f"the App saves '{name}' as {package}.{behavior_module(name)}/{behavior_class(name)}"
    for tag in _DEMANDED:
        if not (root.findtext(tag) or "").strip():
            yield f"the behavior has no {tag}"
    behavior = load(text, known)
    if behavior.name != name:
        yield f"the code is of behavior '{behavior.name}', the manifest of '{name}'"
    used = {
        child.content.definition.name
        for _path, child in walk(behavior.root)
        if isinstance(child.content, BehaviorUse)
    }
    listed = {entry.get("name", "") for entry in root.iter("contains")}
    if used != listed:
        yield f"it contains {sorted(listed)}, the code uses {sorted(used)}"
