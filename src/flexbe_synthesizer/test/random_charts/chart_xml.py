"""What the files of a chart say, read with lxml: the reference's own reader.

Each output of a node is a place that holds the value written last. An input reads the value that
was written last in any of its sources:

- the output that the connection names, or else the chart's input of the same name;
- an input and an output of the chart with one name are one value: what feeds that output, too. A
  chart's output is fed by the connections that name it, else by all outputs of that name.
- A node's output of the name of one of its inputs is the place that the input reads.
"""

from __future__ import annotations

import json
import posixpath
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import yaml
from lxml import etree

from random_charts.kinds import ERROR_NAMES, KINDS, Kind

EXT = "{urn:remodel:statechart:ext:1}"
CHART = ""  # the chart itself, among the ids of its nodes
Place = tuple[str, str]  # node, output; or CHART and an input of the chart


@dataclass(eq=False)
class Node:
    """A state, behavior or container.

    Attributes:
        kind: what its class offers, or a behavior of which that is all that is known; else None.
        events: event -> target; empty in a concurrency container.
        optional: inputs with a default of their own.
        scope: what is in it, None with a kind.
        own: the outcomes of its class, behavior or container.
    """

    id: str
    tag: str
    type: str
    kind: Kind | None
    own: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    events: Mapping[str, str]
    params: Mapping[str, object]
    topic: str | None
    attempts: int | None
    timeout_s: float | None
    routes: tuple[tuple[frozenset[int], str], ...]
    optional: frozenset[str] = frozenset()
    scope: Scope | None = None

    @property
    def is_timed(self) -> bool:
        """Whether a timer beside it keeps its timeout."""
        keeps_time = self.kind is not None and self.kind.keeps_time
        return self.timeout_s is not None and not keeps_time


@dataclass(eq=False)
class Scope:
    """What a chart or container holds.

    Attributes:
        inputs: name -> default; `...` without one.
        connections: (state, output, state, input), CHART for the chart or container itself.
        initial: empty in a concurrency container.
    """

    name: str
    initial: str
    nodes: dict[str, Node]
    inputs: dict[str, object]
    outputs: tuple[str, ...]
    outcomes: tuple[str, ...]
    connections: tuple[tuple[str, str, str, str], ...]
    conditions: tuple[tuple[str, dict[str, str]], ...] = ()
    _places: dict[Place, Place] = field(default_factory=dict)

    @cached_property
    def into(self) -> Mapping[Place, Place]:
        """What the connection into each input comes from."""
        return {(si, i): (so, o) for so, o, si, i in reversed(self.connections) if si != CHART}

    def source(self, node: str, key: str) -> Place | None:
        """Return what an input names as its source: an output, an input of the chart, or none."""
        named = self.into.get((node, key))
        return named or ((CHART, key) if key in self.inputs else None)

    def place(self, node: str, key: str) -> Place:
        """Return the place that an output is written to."""
        trail: list[Place] = []
        here = (node, key)
        while here not in trail and here[0] != CHART and here[1] in self.nodes[here[0]].inputs:
            trail.append(here)
            source = self.source(*here)
            if source is None:
                break
            here = source
        return here if here not in trail else trail[0]

    def feeders(self, output: str) -> frozenset[Place]:
        """Return the places that an output of the chart is read from."""
        if output not in self._fed:
            named = [(so, o) for so, o, si, i in self.connections if (si, i) == (CHART, output)]
            nodes = self.nodes.values()
            found = named or [(n.id, output) for n in nodes if output in n.outputs]
            places = {self.place(*port) for port in found if port[0] != CHART}
            self._fed[output] = frozenset(
                places | ({(CHART, output)} if output in self.inputs else set())
            )
        return self._fed[output]

    @cached_property
    def _fed(self) -> dict[str, frozenset[Place]]:
        return {}

    @cached_property
    def _read(self) -> dict[Place, frozenset[Place]]:
        return {}

    def sources(self, node: str, key: str) -> frozenset[Place]:
        """Return the places that an input is read from; none if nothing feeds it."""
        if (node, key) not in self._read:
            named = self.source(node, key)
            place = None if named is None else self.place(*named)
            found = {place} if place is not None else set()
            for output in self.outputs:
                if output in self.inputs and place in self.feeders(output):
                    found |= self.feeders(output)
            self._read[node, key] = frozenset(found)
        return self._read[node, key]


@dataclass(frozen=True)
class _Known:
    """What charts can name: other charts, by path, and classes."""

    files: Mapping[str, bytes]
    kinds: Mapping[str, Kind]


def read_chart(
    files: Mapping[str, bytes], path: str, kinds: Mapping[str, Kind] = MappingProxyType(KINDS)
) -> Scope:
    """Return what a chart says, and those that it names."""
    return _chart(_Known(files, kinds), path)


def _chart(known: _Known, path: str) -> Scope:
    return _scope(etree.fromstring(known.files[path]), "name", known, path)


def _scope(element: etree._Element, name: str, known: _Known, path: str) -> Scope:
    own = element.get(name)
    data = element.find("datamodel")
    nodes = {}
    for child in element:
        if isinstance(child.tag, str) and child.get("id") is not None:
            nodes[child.get("id")] = _node(child, known, path)
    ends = ("output_state_id", "output", "input_state_id", "input")
    connections = [
        [child.get(end) for end in ends]
        for child in element.iter("connection")
        if child.getparent() is element
    ]
    return Scope(
        own,
        element.get("initial", ""),
        nodes=nodes,
        inputs={i.get("name"): _default(i) for i in data.findall("input")},
        outputs=tuple(o.get("name") for o in data.findall("output")),
        outcomes=tuple(o.get("name") for o in data.iter("outcome")),
        connections=tuple(
            (CHART if so == own else so, o, CHART if si == own else si, i)
            for so, o, si, i in connections
        ),
        conditions=tuple(
            (c.get("outcome"), {w.get("state"): w.get("event") for w in c})
            for c in element.findall(f"{EXT}condition")
        ),
    )


def _class(element: etree._Element) -> str:
    """Return the class that a type names: `Class`, `package/Class` or `package__Class`."""
    return element.get("type", "").rpartition("/")[2].rpartition("__")[2]


def _default(element: etree._Element) -> object:
    text = element.get(f"{EXT}default")
    return ... if text is None else _literal(text)


def _literal(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return yaml.safe_load(text)  # in other quotation marks, or a text without


def _node(element: etree._Element, known: _Known, path: str) -> Node:
    tag = etree.QName(element).localname
    params = {p.get("name"): _literal(p.get("value")) for p in element.findall("param")}
    optional: frozenset[str] = frozenset()
    kind = known.kinds.get(_class(element)) if tag in ("state", "behavior") else None
    if kind is not None:
        scope = None
        own = kind.outcomes or tuple(params["outcomes"])
        inputs = tuple(params["input_keys"]) if kind.inputs is None else kind.inputs
        outputs = tuple(params["output_keys"]) if kind.outputs is None else kind.outputs
    else:
        if tag == "behavior":
            inner = posixpath.normpath(posixpath.join(posixpath.dirname(path), element.get("type")))
            scope = _chart(known, inner)
            optional = frozenset(k for k, default in scope.inputs.items() if default is not ...)
        else:
            scope = _scope(element, "id", known, path)
        own, inputs, outputs = scope.outcomes, tuple(scope.inputs), scope.outputs
    attempts, timeout = element.get(f"{EXT}attempts"), element.get(f"{EXT}timeout_s")
    return Node(
        element.get("id"),
        tag,
        type=_class(element),
        kind=kind,
        own=own,
        inputs=inputs,
        outputs=outputs,
        events={t.get("event"): t.get("target") for t in element.findall("transition")},
        params=params,
        topic=element.get("topic"),
        attempts=None if attempts is None else int(attempts),
        timeout_s=None if timeout is None else float(timeout),
        routes=_routes(element.get(f"{EXT}on_error")),
        optional=optional,
        scope=scope,
    )


def _routes(text: str | None) -> tuple[tuple[frozenset[int], str], ...]:
    routes = []
    for route in (text or "").split(";") if text else ():
        spelled, _, target = route.partition(":")
        codes = ERROR_NAMES.get(spelled.strip())
        if codes is None:
            first, _, last = spelled.partition("-")
            codes = frozenset(range(int(first), int(last or first) + 1))
        routes.append((codes, target.strip()))
    return tuple(routes)
