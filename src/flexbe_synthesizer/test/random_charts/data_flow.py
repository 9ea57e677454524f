"""The data flow of random charts: drawn at random, and mended where it has holes."""

from __future__ import annotations

import itertools
import posixpath
import random
from collections.abc import Iterable, Mapping

from lxml import etree

from random_charts.chart_xml import EXT
from random_charts.explore import MISROUTED, UNROUTED, Fault
from random_charts.parts import KEYS, Part, chance

Roots = Mapping[str, etree._Element]  # the charts, by the names of their files


def wire(rng: random.Random, scope: etree._Element, parts: list[Part], concurrent: bool) -> None:
    """Connect the inputs of the nodes and the outputs of the scope at random."""
    data = scope.find("datamodel")
    name = scope.get("name", scope.get("id"))
    givers = [
        (part.element.get("id"), key)
        for part in parts
        for key in part.outputs
        for _ in range(1 if part.element.tag == "state" else 3)
    ]
    for part in parts:
        node_id = part.element.get("id")
        for key in part.inputs:
            own = [i.get("name") for i in data.findall("input")]
            others = [] if concurrent and chance(rng, 0.95) else givers
            if key in own and chance(rng, 0.5):
                continue
            if others and chance(rng, 0.75):
                giver = rng.choice([g for g in others if g[0] != node_id] or others)
            elif own and chance(rng, 0.7):
                giver = (name, rng.choice(own))
            else:
                if key not in own:
                    etree.SubElement(data, "input", name=key)
                continue
            _connect(scope, giver, (node_id, key))
    _wire_outputs(rng, scope, data, name, parts=parts)


def _wire_outputs(
    rng: random.Random,
    scope: etree._Element,
    data: etree._Element,
    name: str,
    parts: list[Part],
) -> None:
    free = [(p.element.get("id"), k) for p in parts for k in p.outputs if k not in p.inputs]
    rng.shuffle(free)
    for _ in range(rng.randint(0, 3)):
        connected = {key for _node, key in _connected_to(scope, name)}
        by_name = {key for _node, key in free} - connected
        if by_name and chance(rng, 0.5):
            output = rng.choice(sorted(by_name))
        elif free:
            output = rng.choice([*KEYS, "out", "found"])
        else:
            return
        if any(o.get("name") == output for o in data.findall("output")):
            continue
        if output in by_name and chance(rng, 0.8):
            etree.SubElement(data, "output", name=output)
            free = [port for port in free if port[1] != output]
        elif free:
            etree.SubElement(data, "output", name=output)
            for _ in range(min(len(free), rng.randint(1, 2))):
                _connect(scope, free.pop(), (name, output))


def _connected_to(scope: etree._Element, name: str) -> set[tuple[str, str]]:
    """Return the outputs of nodes that feed outputs of the scope."""
    found = [c for c in scope.findall("connection") if c.get("input_state_id") == name]
    return {(c.get("output_state_id"), c.get("output")) for c in found}


def mend(roots: Roots, path: str, faults: Iterable[Fault]) -> None:
    """Feed what is read and may be missing from outside, and drop routes by codes that are not."""
    for fault in faults:
        scopes, file = [(roots[path], path)], path
        *above, node_id = fault.path.split("/")[1:]
        for part in above:
            element = _child(scopes[-1][0], part)
            if element.tag == "behavior":
                file = _inner_path(file, element)
                element = roots[file]
            scopes.append((element, file))
        node = _child(scopes[-1][0], node_id)
        if fault.what in (MISROUTED, UNROUTED):
            node.attrib.pop(f"{EXT}on_error", None)
        else:
            _feed_from_outside(roots, scopes[-1][0], node_id, fault.key)


def _feed_from_outside(roots: Roots, scope: etree._Element, node_id: str, key: str) -> None:
    """Feed an input by a new input of the scope, that input by one around it, and so on."""
    data = scope.find("datamodel")
    taken = {port.get("name") for port in data if port.tag in ("input", "output")}
    name = next(
        n
        for n in itertools.chain([f"{key}_given"], (f"{key}_{i}" for i in itertools.count(2)))
        if n not in taken
    )
    etree.SubElement(data, "input", name=name)
    for connection in scope.findall("connection"):
        if (connection.get("input_state_id"), connection.get("input")) == (node_id, key):
            scope.remove(connection)
    _connect(scope, (scope.get("name", scope.get("id")), name), (node_id, key))
    if scope.get("id") is not None:
        around = scope.getparent()
        _feed_from_outside(roots, around, scope.get("id"), name)
        return
    path = next(p for p, root in roots.items() if root is scope)
    for other_path, root in roots.items():
        for behavior in list(root.iter("behavior")):
            if _inner_path(other_path, behavior) == path:
                _feed_from_outside(roots, behavior.getparent(), behavior.get("id"), name)


def _inner_path(path: str, behavior: etree._Element) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), behavior.get("type")))


def _child(scope: etree._Element, node_id: str) -> etree._Element:
    return next(child for child in scope if child.get("id") == node_id)


def _connect(scope: etree._Element, giver: tuple[str, str], taker: tuple[str, str]) -> None:
    etree.SubElement(
        scope,
        "connection",
        output_state_id=giver[0],
        output=giver[1],
        input_state_id=taker[0],
        input=taker[1],
    )
