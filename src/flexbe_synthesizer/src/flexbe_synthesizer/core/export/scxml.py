"""Write a chart as W3C SCXML (https://www.w3.org/TR/scxml/), for other statechart tools.

A state waits for the events `ID.EVENT` of its own path, which the executing program sends; the
blanks of names become `_`. An outcome of the chart is a final state of its name. Attempts are
counted in the data model (`ecmascript`), by a state `ID._attempts` before the state itself; no name
of the chart begins with `_`. A timeout sends the event `ID.timed_out` after its time. Routes by
error code evaluate `_event.data.error_code`. A container is a compound state whose final states
raise `ID.OUTCOME`; a concurrency container is a parallel state, left as soon as the final states of
its regions fulfil a condition. The flow of data is FlexBE's and is left out.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from types import MappingProxyType

from lxml import etree

from flexbe_synthesizer.core.chart.error_routes import codes_of_routes, spans
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Condition,
    Container,
    ContainerKind,
    walk_nodes,
)
from flexbe_synthesizer.core.chart.names import EXHAUSTED, FAILED, TIMED_OUT

ErrorNames = Mapping[str, tuple[int, ...]]
NAMESPACE = "http://www.w3.org/2005/07/scxml"


class ScxmlError(ValueError):
    """A chart cannot be written as SCXML."""


def chart_to_scxml(chart: Chart, error_names: ErrorNames = MappingProxyType({})) -> str:
    """Return the SCXML document of a checked chart.

    Args:
        chart: what to write.
        error_names: error codes by the names of codes and of classes of codes.

    Raises:
        ScxmlError: if two of its names are the same name there.
    """
    root = etree.Element(
        f"{{{NAMESPACE}}}scxml",
        nsmap={None: NAMESPACE},
        version="1.0",
        name=scxml_name(chart.name),
        datamodel="ecmascript",
        initial=_entry(chart, "", chart.initial),
    )
    if any(node.attempts is not None for node in walk_nodes(chart)):
        data = _add(root, "datamodel")
        for count in _counts(chart, ""):
            _add(data, "data", id=count, expr="0")
    _add_sequence(root, chart, "", error_names)
    for outcome in chart.outcomes:
        _add(root, "final", id=scxml_name(outcome.name))
    _expect_distinct(root)
    etree.indent(root)
    text: str = etree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _expect_distinct(root: etree._Element) -> None:
    found: set[str] = set()
    for node_id in root.xpath("//@id"):
        if node_id in found:
            raise ScxmlError(
                f"two names of the chart become the SCXML id '{node_id}', which has neither blanks "
                "nor dots; rename one of them"
            )
        found.add(node_id)


def scxml_name(text: str) -> str:
    """Return a name as part of an id or event: no blanks, and nothing that has a meaning there."""
    return re.sub(r"[^\w-]", "_", text)


def _add(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
    return etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}", attributes)


def _id(prefix: str, name: str) -> str:
    return f"{prefix}{scxml_name(name)}"


def _count(node_id: str) -> str:
    """Return the variable that counts the visits to a node, by the node's SCXML id."""
    return "visits_" + re.sub(r"\W", "_", node_id)


def _counts(chart: Chart, prefix: str) -> Iterator[str]:
    for node in chart.nodes:
        node_id = _id(prefix, node.id)
        if node.attempts is not None:
            yield _count(node_id)
        if isinstance(node, Container):
            yield from _counts(node.body, f"{node_id}.")


def _entry(chart: Chart, prefix: str, target: str) -> str:
    """Return the id of the state that a transition to a node or outcome leads to."""
    is_counted = any(n.id == target and n.attempts is not None for n in chart.nodes)
    return _id(prefix, target) + "._attempts" * is_counted


def _add_sequence(
    parent: etree._Element, chart: Chart, prefix: str, error_names: ErrorNames
) -> None:
    """Append the nodes of a chart or container that are run one after another."""
    for node in chart.nodes:
        targets = {t.event: _entry(chart, prefix, t.target) for t in node.transitions}
        node_id = _id(prefix, node.id)
        if node.attempts is not None:
            _add_counter(parent, node_id, node.attempts, targets.pop(EXHAUSTED))
        element = _add_node(parent, node, node_id, targets, error_names=error_names)
        routed = codes_of_routes(node.on_error, error_names)
        for route, codes in zip(node.on_error, routed, strict=True):
            target, condition = _entry(chart, prefix, route.target), _has_code(codes)
            _add(element, "transition", event=f"{node_id}.{FAILED}", cond=condition, target=target)
        for event, target in targets.items():
            _add_exit(element, node, node_id, event, target=target)


def _add_counter(parent: etree._Element, node_id: str, attempts: int, exhausted: str) -> None:
    """Append the state that lets a node be entered a number of times."""
    count = _count(node_id)
    counter = _add(parent, "state", id=f"{node_id}._attempts")
    again = _add(counter, "transition", cond=f"{count} < {attempts}", target=node_id)
    _add(again, "assign", location=count, expr=f"{count} + 1")
    _add(counter, "transition", target=exhausted)


def _add_node(
    parent: etree._Element,
    node: AnyNode,
    node_id: str,
    events: Collection[str],
    error_names: ErrorNames,
) -> etree._Element:
    """Append a node with all that is in it, but what its events lead to."""
    if not isinstance(node, Container):
        element = _add(parent, "state", id=node_id)
    elif node.runs is ContainerKind.CONCURRENCY:
        element = _add(parent, "parallel", id=node_id)
        for region in node.body.nodes:
            whens = (when for condition in node.body.conditions for when in condition.all_of)
            events = [scxml_name(when.event) for when in whens if when.state == region.id]
            region_id = _id(f"{node_id}.", region.id)
            _add_region(element, region, region_id, events, error_names=error_names)
    else:
        inside = f"{node_id}."
        initial = _entry(node.body, inside, node.body.initial)
        element = _add(parent, "state", id=node_id, initial=initial)
        _add_sequence(element, node.body, inside, error_names)
        for outcome in node.body.outcomes:
            final = _add(element, "final", id=_id(inside, outcome.name))
            _add(_add(final, "onentry"), "raise", event=_id(inside, outcome.name))
    if node.timeout_s is not None and TIMED_OUT in events:
        timer = f"{node_id}._timer"
        event = f"{node_id}.{TIMED_OUT}"
        delay = f"{node.timeout_s}s"
        _add(_add(element, "onentry"), "send", id=timer, event=event, delay=delay)
        _add(_add(element, "onexit"), "cancel", sendid=timer)
    return element


def _add_region(
    parent: etree._Element,
    node: AnyNode,
    node_id: str,
    events: Collection[str],
    error_names: ErrorNames,
) -> None:
    """Append a node of a concurrency container: the node, and a final state for each event."""
    region = _add(parent, "state", id=f"{node_id}._region", initial=node_id)
    element = _add_node(region, node, node_id, events, error_names=error_names)
    for event in events:
        _add(element, "transition", event=f"{node_id}.{event}", target=f"{node_id}._ended.{event}")
        _add(region, "final", id=f"{node_id}._ended.{event}")


def _add_exit(
    element: etree._Element, node: AnyNode, node_id: str, event: str, target: str
) -> None:
    """Append what leads out of a node with an event."""
    if isinstance(node, Container) and node.runs is ContainerKind.CONCURRENCY:
        for condition in node.body.conditions:
            if condition.outcome == event:
                _add(element, "transition", cond=_holds(condition, node_id), target=target)
        if event != TIMED_OUT:
            return
    _add(element, "transition", event=f"{node_id}.{scxml_name(event)}", target=target)


def _holds(condition: Condition, node_id: str) -> str:
    ended = (
        f"In('{_id(f'{node_id}.', when.state)}._ended.{scxml_name(when.event)}')"
        for when in condition.all_of
    )
    return " && ".join(ended)


def _has_code(codes: Iterable[int]) -> str:
    code = "_event.data.error_code"
    rows = (f"{code} >= {first} && {code} <= {last}" for first, last in spans(codes))
    return " || ".join(rows)
