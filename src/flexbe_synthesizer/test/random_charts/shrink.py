"""From a chart on which engine and reference do not agree, a small one."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator, Mapping

from lxml import etree

from random_charts.chart_xml import EXT

_LIMITS = [f"{EXT}{name}" for name in ("attempts", "timeout_s", "on_error", "autonomy", "default")]
Files = Mapping[str, bytes]


def shrink(files: Files, path: str, is_wrong: Callable[[Files], bool]) -> Files:
    """Return charts as small as simple steps make them, on which `is_wrong` still holds."""
    found, has_shrunk = _needed(files, path), True
    while has_shrunk:
        has_shrunk = False
        for smaller in _smaller(found):
            smaller = _needed(smaller, path)
            if is_wrong(smaller):
                found, has_shrunk = smaller, True
                break
    return {name: _printed(content) for name, content in found.items()}


def _printed(content: bytes) -> bytes:
    root = etree.fromstring(content, etree.XMLParser(remove_blank_text=True))
    return etree.tostring(root, encoding="UTF-8", pretty_print=True)


def _smaller(files: Files) -> Iterator[Files]:
    """Yield the charts with one thing less each, large things first."""
    for name, content in files.items():
        for index, element in enumerate(etree.fromstring(content).iter()):
            for change in _changes(element):
                root = etree.fromstring(content)
                change(next(e for i, e in enumerate(root.iter()) if i == index))
                yield {**files, name: etree.tostring(root, encoding="UTF-8")}


def _changes(element: etree._Element) -> Iterator[Callable[[etree._Element], None]]:
    """Yield what can be done with an element."""
    if element.get("id") is not None:
        yield _remove_node
    if element.tag in ("connection", "input", "output", "outcome", f"{EXT}condition"):
        yield _remove
    for limit in _LIMITS:
        if element.get(limit) is not None:
            yield lambda found, limit=limit: _without_limit(found, limit)


def _remove(element: etree._Element) -> None:
    element.getparent().remove(element)


def _without_limit(element: etree._Element, limit: str) -> None:
    del element.attrib[limit]
    event = {f"{EXT}attempts": "exhausted", f"{EXT}timeout_s": "timed_out"}.get(limit)
    for transition in element.findall("transition"):
        if transition.get("event") == event:
            element.remove(transition)


def _remove_node(element: etree._Element) -> None:
    """Remove a node; what led to it leads where its first transition led."""
    scope, node_id = element.getparent(), element.get("id")
    transition = element.find("transition")
    target = (
        scope.find(".//outcome").get("name") if transition is None else transition.get("target")
    )
    target = scope.find(".//outcome").get("name") if target == node_id else target
    scope.remove(element)
    for other in scope.findall("*/transition"):
        if other.get("target") == node_id:
            other.set("target", target)
    for other in scope:
        routes = other.get(f"{EXT}on_error")
        if routes:
            other.set(f"{EXT}on_error", routes.replace(f": {node_id}", f": {target}"))
    if scope.get("initial") == node_id:
        scope.set("initial", target)
    for connection in scope.findall("connection"):
        if node_id in (connection.get("output_state_id"), connection.get("input_state_id")):
            scope.remove(connection)
    for condition in scope.findall(f"{EXT}condition"):
        for when in condition:
            if when.get("state") == node_id:
                condition.remove(when)
        if not len(condition):
            scope.remove(condition)


def _needed(files: Files, path: str) -> Files:
    """Return the charts that one names, and itself."""
    found: dict[str, bytes] = {}
    waiting = [path]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = files[name]
            for behavior in etree.fromstring(files[name]).iter("behavior"):
                inner = posixpath.join(posixpath.dirname(name), behavior.get("type"))
                waiting.append(posixpath.normpath(inner))
    return found
