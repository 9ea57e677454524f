"""Render a behavior as the Python file that the FlexBE App writes and reads back.

The template is the file's layout; what it calls returns one line or value each. Lines are indented
by four blanks, continued lines by ten times that, as the App does.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import Autonomy, quote
from flexbe_synthesizer.core.export.layout import Layout, Point
from flexbe_synthesizer.core.library.sources import AUTHOR, DATE
from flexbe_synthesizer.core.machine.machine import (
    BehaviorUse,
    Child,
    Container,
    Kind,
    Machine,
    StateUse,
    python_value,
    walk,
)

if TYPE_CHECKING:
    import jinja2

_INDENT = " " * 4
_LINE = "\n" + _INDENT * 3
_BETWEEN = "\n" + _LINE
_CONTINUED = "\n" + _INDENT * 10
_ROOT = "_state_machine"
_LEVELS = {level: f"Autonomy.{level.value.capitalize()}" for level in Autonomy}

_TEMPLATE = """\
#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, \
PriorityContainer, Logger
{% for line in imports %}
{{ line }}
{% endfor %}
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]{{ manual.IMPORT }}# [/MANUAL_IMPORT]


'''
Created on {{ date }}
@author: {{ author }}
'''
class {{ class_name }}(Behavior):
    '''
    {{ description }}
    '''


    def __init__(self):
        super({{ class_name }}, self).__init__()
        self.name = {{ name }}

        # parameters of this behavior

        # references to used behaviors
        {% for class_name, path in behaviors %}
        self.add_behavior({{ class_name }}, {{ path }})
        {% endfor %}

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]{{ manual.INIT }}# [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        {{ root.outcomes }}
        {{ root.variable }} = {{ root.definition }}
        {% for default in userdata %}
        {{ default }}
        {% endfor %}

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]{{ manual.CREATE }}# [/MANUAL_CREATE]

        {% for container in containers %}
        {{ container.outcomes }}
        {{ container.variable }} = {{ container.definition }}

        with {{ container.variable }}:
            {{ container.children }}


        {% endfor %}
        with {{ root.variable }}:
            {{ root.children }}


        return {{ root.variable }}


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]{{ manual.FUNC }}# [/MANUAL_FUNC]
"""
_HARMLESS = {ord("'"): "\u2019", ord("\\"): "/", ord("["): "(", ord("]"): ")"}
_EMPTY_SECTIONS = {
    "IMPORT": "\n\n",
    "INIT": "\n\n" + _INDENT * 2,
    "CREATE": "\n\n" + _INDENT * 2,
    "FUNC": "\n\n" + _INDENT,
}


def render_python(machine: Machine, layout: Layout, manual: Mapping[str, str]) -> str:
    """Return the text of the behavior's file.

    Args:
        machine: the behavior.
        layout: where everything in it stands.
        manual: content of the manual sections of the file before; missing ones are empty.
    """
    uses = [(path, child.content) for path, child in walk(machine.root)]
    inner = sorted(
        [(path, use) for path, use in uses if isinstance(use, Container)], key=itemgetter(0)
    )
    behaviors = sorted(
        [(path, use) for path, use in uses if isinstance(use, BehaviorUse)], key=itemgetter(0)
    )
    writer = _Writer(layout, _variables([path for path, _container in inner]))
    return _compiled_template().render(
        imports=_imports([content for _path, content in uses]),
        manual={**_EMPTY_SECTIONS, **manual},
        date=DATE,
        author=_docstring(" ".join(machine.author.split())) or AUTHOR,
        class_name=names.behavior_class(machine.name),
        description=_docstring(machine.description),
        name=quote(machine.name),
        behaviors=[
            (content.behavior.class_name, quote(path.lstrip("/"))) for path, content in behaviors
        ],
        userdata=[
            f"{_ROOT}.userdata.{key} = {python_value(value)}"
            for key, value in machine.root.userdata
        ],
        root=writer.container("", machine.root),
        containers=[writer.container(path, content) for path, content in reversed(inner)],
    )


@cache
def _compiled_template() -> jinja2.Template:
    import jinja2  # here, since it is a fifth of the start of a program that only checks charts

    return jinja2.Environment(
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    ).from_string(_TEMPLATE)


def _variables(inner: Sequence[str]) -> Mapping[str, str]:
    """Return the variable of each container by its path, given the sorted paths of inner ones.

    It is the one that the FlexBE App gives it, where that is Python.
    """
    numbered = {}
    for number, path in enumerate(reversed(inner)):
        name = path.rpartition("/")[2]
        part = name.lower().replace(" ", "_")
        if not f"_sm_{part}".isidentifier():
            part = names.behavior_file(name)
        numbered[path] = f"_sm_{part}_{number}"
    return {"": _ROOT, **numbered}


def _imports(uses: Iterable[StateUse | BehaviorUse | Container]) -> list[str]:
    """Return the import line of each class used."""
    found = set()
    for use in uses:
        if isinstance(use, StateUse):
            found.add((use.state.module, use.state.name, use.alias))
        elif isinstance(use, BehaviorUse):
            behavior = use.behavior
            found.add((behavior.module, behavior.class_name, behavior.class_name))
    return sorted(
        f"from {module} import {name}" + (f" as {alias}" if alias != name else "")
        for module, name, alias in found
    )


def _docstring(text: str) -> str:
    """Return a description that cannot be taken for code, by Python or by the FlexBE App."""
    swapped = text.translate(_HARMLESS)
    calm = re.sub(r"\b(class|def)\b(?=\s)", "\u201c\\1\u201d", swapped)
    calm = re.sub(r"^(\s*)(from|import)\b", "\\1\u201c\\2\u201d", calm, flags=re.MULTILINE)
    lines = ("".join(c for c in line if c.isprintable()) for line in calm.splitlines())
    return "\n".join(_INDENT + line if line else "" for line in lines).strip()


class _Writer:
    """Writes containers, and what is in them.

    Attributes:
        layout: where everything stands.
        variables: variable of each container by its path.
    """

    def __init__(self, layout: Layout, variables: Mapping[str, str]) -> None:
        self._layout = layout
        self._variables = variables
        self._quoted = cache(quote)  # the same names stand all over a file

    def container(self, path: str, container: Container) -> Mapping[str, str]:
        """Return what the template shows of a container."""
        points = self._layout.children[path]
        children = [self._child(path, c, points[c.label]) for c in _in_order(container.children)]
        return {
            "variable": self._variables[path],
            "outcomes": _outcome_positions(container, self._layout.outcomes[path]),
            "definition": _definition(container),
            "children": _BETWEEN.join(children),
        }

    def _child(self, above: str, child: Child, point: Point) -> str:
        """Return the comment with a child's place, and the call that adds it to its container."""
        quoted, content = self._quoted, child.content
        default = "Autonomy.Off" if isinstance(content, StateUse) else "Autonomy.Inherit"
        targets = [f"{quoted(exit_[0])}: {quoted(exit_[1])}" for exit_ in child.exits]
        levels = [
            f"{quoted(outcome)}: {default if autonomy is None else _LEVELS[autonomy]}"
            for outcome, _target, autonomy in child.exits
        ]
        homes = [f"{quoted(key)}: {quoted(home)}" for key, home in child.remapping]
        remapping = f",{_CONTINUED}remapping={{{', '.join(homes)}}}" if homes else ""
        x, y = point
        return (
            f"# x:{x} y:{y}{_LINE}OperatableStateMachine.add({quoted(child.label)},{_CONTINUED}"
            f"{self._content(above, child)},{_CONTINUED}transitions={{{', '.join(targets)}}},"
            f"{_CONTINUED}autonomy={{{', '.join(levels)}}}{remapping})"
        )

    def _content(self, above: str, child: Child) -> str:
        """Return the expression for what a child is."""
        content = child.content
        if isinstance(content, StateUse):
            given = [f"{name}={python_value(value)}" for name, value in content.arguments]
            given = given or _first_default(content)
            return f"{content.alias}({', '.join(given)})"
        path = f"{above}/{child.label}"
        if isinstance(content, Container):
            return self._variables[path]
        parts = [content.behavior.class_name, quote(path.lstrip("/"))]
        if content.defaulted:
            parts.append(f"default_keys={_names(content.defaulted)}")
        if content.parameters:
            given = [f"{quote(name)}: {python_value(value)}" for name, value in content.parameters]
            parts.append(f"parameters={{{', '.join(given)}}}")
        return f"self.use_behavior({', '.join(parts)})"


def _first_default(use: StateUse) -> list[str]:
    """Return the argument to write for a state that gets none.

    The FlexBE App takes `()` of a class that has parameters for one empty argument.
    """
    sources = ((p.name, p.default_source) for p in use.state.parameters)
    return next(([f"{name}={source}"] for name, source in sources if source), [])


def _in_order(children: tuple[Child, ...]) -> list[Child]:
    """Return the children as the App writes them.

    The initial one comes first, then the others by label, of which the App moves the first of all
    labels to the end.
    """
    ordered = sorted(children, key=attrgetter("label"))
    initial = children[0]
    if ordered[0] is not initial:
        ordered.append(ordered.pop(0))
    return [initial, *(child for child in ordered if child is not initial)]


def _outcome_positions(container: Container, points: Mapping[str, Point]) -> str:
    """Return the comment with the places of a container's outcomes.

    For a concurrency container the App counts an empty slot, and one more per repeated outcome.
    """
    places = [points[outcome] for outcome in container.outcomes]
    if container.conditions:
        outcomes = [condition.outcome for condition in container.conditions]
        repeated = [o for i, o in enumerate(outcomes) if o in outcomes[:i]]
        places += [places[-1], *(points[outcome] for outcome in repeated)]
    return "# " + ", ".join(f"x:{x} y:{y}" for x, y in places)


def _definition(container: Container) -> str:
    """Return the constructor call of a container."""
    lists = {
        "outcomes": container.outcomes,
        "input_keys": container.input_keys,
        "output_keys": container.output_keys,
    }
    given = [f"{k}={_names(v)}" for k, v in lists.items() if v or k == "outcomes"]
    if container.kind is Kind.CONCURRENCY:
        tuples = f",{_CONTINUED}".join(
            f"({quote(outcome)}, [{', '.join(map(_pair, pairs))}])"
            for outcome, pairs in container.conditions
        )
        given.append(f"conditions=[{_CONTINUED}{tuples}{_CONTINUED}]")
    return f"{container.kind.value}({', '.join(given)})"


def _pair(pair: tuple[str, str]) -> str:
    return f"({quote(pair[0])}, {quote(pair[1])})"


def _names(listed: Iterable[str]) -> str:
    return "[" + ", ".join(map(quote, listed)) + "]"
