"""Render a behavior as the Python file that the FlexBE App writes and reads back.

The template is the file's layout; what it calls returns one line or value each. Lines are indented
by four blanks, continued lines by ten times that, as the App does.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import jinja2

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.layout import Layout, Point
from flexbe_synthesizer.core.literal import quote
from flexbe_synthesizer.core.machine import (
    BehaviorUse,
    Child,
    Container,
    Exit,
    Kind,
    Machine,
    Pair,
    StateUse,
    python_value,
    walk,
)
from flexbe_synthesizer.core.manifest import AUTHOR, DATE

_INDENT = " " * 4
_CONTINUED = "\n" + _INDENT * 10
_ROOT = "_state_machine"

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
            {% for child in container.children %}
            {{ child.position }}
            {{ child.add }}

            {% endfor %}

        {% endfor %}
        with {{ root.variable }}:
            {% for child in root.children %}
            {{ child.position }}
            {{ child.add }}

            {% endfor %}

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
_COMPILED = jinja2.Environment(
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
    undefined=jinja2.StrictUndefined,
).from_string(_TEMPLATE)


def render_python(machine: Machine, layout: Layout, manual: Mapping[str, str]) -> str:
    """Return the text of the behavior's file.

    Args:
        machine: the behavior.
        layout: where everything in it stands.
        manual: content of the manual sections of the file before; missing ones are empty.
    """
    variables = _variables(machine.root)
    paths = sorted((path for path in variables if path), reverse=True)
    below = dict(walk(machine.root))
    uses = [(path, child.content) for path, child in sorted(below.items())]
    return _COMPILED.render(
        imports=_imports(content for _path, content in uses),
        manual={**_EMPTY_SECTIONS, **manual},
        date=DATE,
        author=AUTHOR,
        class_name=names.behavior_class(machine.name),
        description=_docstring(machine.description),
        name=quote(machine.name),
        behaviors=[
            (content.behavior.class_name, quote(path.lstrip("/")))
            for path, content in uses
            if isinstance(content, BehaviorUse)
        ],
        userdata=[
            f"{_ROOT}.userdata.{key} = {python_value(value)}"
            for key, value in machine.root.userdata
        ],
        root=_container("", machine.root, layout, variables),
        containers=[
            _container(path, content, layout, variables)
            for path in paths
            if isinstance(content := below[path].content, Container)
        ],
    )


def _variables(root: Container) -> Mapping[str, str]:
    """Return the variable of each container by its path."""
    inner = sorted(
        (path for path, child in walk(root) if isinstance(child.content, Container)), reverse=True
    )
    numbered = {}
    for number, path in enumerate(inner):
        label = re.sub(r"\W", "_", path.rpartition("/")[2].lower())
        numbered[path] = f"_sm_{label}_{number}"
    return {"": _ROOT, **numbered}


def _imports(uses: Iterable[StateUse | BehaviorUse | Container]) -> list[str]:
    """Return the import line of each class used."""
    lines = set()
    for use in uses:
        if isinstance(use, StateUse):
            alias = "" if use.alias == use.state.name else f" as {use.alias}"
            lines.add(f"from {use.state.module} import {use.state.name}{alias}")
        elif isinstance(use, BehaviorUse):
            lines.add(f"from {use.behavior.module} import {use.behavior.class_name}")
    return sorted(lines)


def _docstring(text: str) -> str:
    """Return a description that cannot be taken for code, by Python or by the FlexBE App."""
    swapped = text.translate(_HARMLESS)
    calm = re.sub(r"\b(class|def)\b(?=\s)", "\u201c\\1\u201d", swapped)
    calm = re.sub(r"^(\s*)(from|import)\b", "\\1\u201c\\2\u201d", calm, flags=re.MULTILINE)
    lines = ("".join(c for c in line if c.isprintable()) for line in calm.splitlines())
    return "\n".join(_INDENT + line if line else "" for line in lines).strip()


def _container(
    path: str, container: Container, layout: Layout, variables: Mapping[str, str]
) -> Mapping[str, object]:
    """Return what the template shows of a container."""
    return {
        "variable": variables[path],
        "outcomes": _outcome_positions(container, layout.outcomes[path]),
        "definition": _definition(container),
        "children": [
            {
                "position": _position(layout.children[f"{path}/{child.label}"]),
                "add": _add(f"{path}/{child.label}", child, variables),
            }
            for child in _in_order(container.children)
        ],
    }


def _in_order(children: tuple[Child, ...]) -> list[Child]:
    """Return the children as the App writes them.

    The initial one comes first, then the others by label, of which the App moves the first of all
    labels to the end.
    """
    ordered = sorted(children, key=lambda child: child.label)
    initial = children[0]
    if ordered[0] is not initial:
        ordered.append(ordered.pop(0))
    ordered.remove(initial)
    return [initial, *ordered]


def _position(point: Point) -> str:
    return f"# x:{point[0]} y:{point[1]}"


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


def _add(path: str, child: Child, variables: Mapping[str, str]) -> str:
    """Return the call that adds a child to its container."""
    transitions = {exit_.outcome: quote(exit_.target) for exit_ in child.exits}
    parts = [
        _content(path, child.content, variables),
        f"transitions={_dictionary(transitions)}",
        f"autonomy={_dictionary({e.outcome: _autonomy(e, child) for e in child.exits})}",
    ]
    if child.remapping:
        homes = {key: quote(home) for key, home in child.remapping}
        parts.append(f"remapping={_dictionary(homes)}")
    return f"OperatableStateMachine.add({quote(child.label)},{_CONTINUED}" + (
        f",{_CONTINUED}".join(parts) + ")"
    )


def _content(
    path: str, content: StateUse | BehaviorUse | Container, variables: Mapping[str, str]
) -> str:
    """Return the expression for what a child is."""
    if isinstance(content, Container):
        return variables[path]
    if isinstance(content, StateUse):
        arguments = (f"{name}={python_value(value)}" for name, value in content.arguments)
        return f"{content.alias}({', '.join(arguments)})"
    parts = [content.behavior.class_name, quote(path.lstrip("/"))]
    if content.defaulted:
        parts.append(f"default_keys={_names(content.defaulted)}")
    if content.parameters:
        parts.append(f"parameters={_parameters(content.parameters)}")
    return f"self.use_behavior({', '.join(parts)})"


def _parameters(pairs: Iterable[Pair]) -> str:
    return _dictionary({name: python_value(value) for name, value in pairs})


def _dictionary(items: Mapping[str, str]) -> str:
    return "{" + ", ".join(f"{quote(key)}: {value}" for key, value in items.items()) + "}"


def _autonomy(exit_: Exit, child: Child) -> str:
    """Return the autonomy of an outcome; without one, states wait for nothing, others inherit."""
    if exit_.autonomy is not None:
        return f"Autonomy.{exit_.autonomy.value.capitalize()}"
    return "Autonomy.Off" if isinstance(child.content, StateUse) else "Autonomy.Inherit"
