"""Save a behavior as the App does."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from flexbe_testing.app.behavior import (
    AppBehavior,
    BehaviorUse,
    Child,
    Container,
    StateUse,
    walk,
)
from flexbe_testing.app.known import Known

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
                name, alias = content.definition.class_name, self._known.alias(content.definition)
                line = f"from {content.definition.module} import {name}"
                found.add(line if name == alias else f"{line} as {alias}")
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
        if container.is_concurrent:
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
        levels = [f"'{outcome}': {child.level(outcome)}" for outcome in outcomes]
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
            return f"{self._known.alias(content.definition)}({', '.join(given)})"
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
