"""Change the text of a chart in place: what a change does not concern stays byte for byte.

The chart that the text holds and the chart that is wanted are compared part by part, and each
difference becomes an edit of the text. Comments, blanks, quotes, the order of attributes and the
spelling of values stay as the author wrote them.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element

from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.chart_writer import (
    Part,
    Style,
    chart_part,
    comment,
    escaped,
    expect_xml,
    write_chart,
)
from flexbe_synthesizer.core.chart.error_routes import common_ends, parse_routes, respelled
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.text_edits import Edits, Markup, Place, XmlLayout, style_of

_NODES = {"state", "behavior", "ext:container", "ext:concurrency", "ext:priority"}
NODE = "node"
# What elements are called by, the first that fits; those of other groups stand once.
_KEYS: dict[str, tuple[tuple[str, ...], ...]] = {
    NODE: (("id",),),
    "outcome": (("name",),),
    "input": (("name",),),
    "output": (("name",),),
    "param": (("name",),),
    "transition": (("event",),),
    "connection": (
        ("output_state_id", "output", "input_state_id", "input"),
        ("input_state_id", "input"),
        ("output_state_id", "output"),
    ),
    "ext:condition": (("outcome",),),
    "ext:when": (("state", "event"), ("state",)),
}


def group_of(part: Part) -> str:
    """Return the kind of an element: those of one kind have an order, others stand anyhow."""
    return NODE if part.tag in _NODES else part.tag


def groups(*parts: Part) -> Iterator[str]:
    """Yield the kinds of elements in the parts, in the order of the language."""
    order = ("datamodel", *_KEYS)
    found = {group_of(child) for part in parts for child in part.children}
    yield from sorted(found, key=lambda group: order.index(group) if group in order else len(order))


def in_group(part: Part, group: str) -> list[Part]:
    """Return the elements of one kind in a part."""
    return [child for child in part.children if group_of(child) == group]


def paired(group: str, olds: Sequence[Part], news: Sequence[Part]) -> list[int | None]:
    """Return for each new element of a kind the index of the old one that it was, if any.

    Equal ones are the same, then those of one name, then those that stand in one place.
    """
    head, tail = common_ends(olds, news)
    middle = _paired(group, olds[head : len(olds) - tail], news[head : len(news) - tail])
    return [
        *range(head),
        *(None if index is None else head + index for index in middle),
        *range(len(olds) - tail, len(olds)),
    ]


def _paired(group: str, olds: Sequence[Part], news: Sequence[Part]) -> list[int | None]:
    found: list[int | None] = [None] * len(news)
    _pair_by(_content, olds, news, found)
    for attributes in _KEYS.get(group, ((),)):
        _pair_by(lambda part, a=attributes: _values(part, a), olds, news, found)  # type: ignore[misc]
    _pair_by_place(olds, news, found)
    return found


def kept_in_order(pairs: Sequence[int | None]) -> set[int]:
    """Return the most of the old indices that stand in order; the others have moved."""
    tails: list[int] = []
    ends: list[int] = []
    came: dict[int, int] = {}
    for old in pairs:
        if old is None:
            continue
        length = bisect_left(ends, old)
        ends[length : length + 1] = [old]
        tails[length : length + 1] = [old]
        came[old] = tails[length - 1] if length else -1
    kept, at = set[int](), tails[-1] if tails else -1
    while at >= 0:
        kept.add(at)
        at = came[at]
    return kept


def _pair_by(
    key: Callable[[Part], Hashable],
    olds: Sequence[Part],
    news: Sequence[Part],
    found: list[int | None],
) -> None:
    """Pair those that have none yet and are of one key, in order."""
    used = set(found)
    waiting: dict[Hashable, list[int]] = {}
    for index, old in enumerate(olds):
        if index not in used:
            waiting.setdefault(key(old), []).append(index)
    for place, new in enumerate(news):
        if found[place] is None and (same := waiting.get(key(new))):
            found[place] = same.pop(0)


def _pair_by_place(olds: Sequence[Part], news: Sequence[Part], found: list[int | None]) -> None:
    """Pair those left over that follow the same element: what was renamed."""
    used = set(found)
    before = -1
    for place, new in enumerate(news):
        if found[place] is None:
            same = before + 1
            if same < len(olds) and same not in used and _is_alike(olds[same], new):
                found[place] = same
                used.add(same)
        paired_with = found[place]
        before = before if paired_with is None else paired_with


def _is_alike(old: Part, new: Part) -> bool:
    """Return whether an element can be another one under a new name."""
    return old.tag == new.tag and old.attributes.get("type") == new.attributes.get("type")


def _values(part: Part, attributes: tuple[str, ...]) -> Hashable:
    return tuple(part.attributes.get(name) for name in attributes)


def _content(part: Part) -> Hashable:
    """Return all that an element says."""
    children = tuple(map(_content, part.children))
    return part.tag, tuple(part.attributes.items()), children


_WHOLE = re.compile(r"[+-]?[0-9]+\Z")


class RewriteError(ValueError):
    """A change cannot be made in the text of a chart."""


def rewrite_chart(text: str, chart: Chart) -> str:
    """Return the text changed so that `parse_chart` reads it as the chart.

    Raises:
        RewriteError: if the text is no chart, or the chart cannot be said in it.
    """
    base, _problems = read_chart(text, chart.file)
    if base is None or base.source is None:
        raise RewriteError(
            "the text is not well-formed XML with a <statemachine>; correct it first"
        )
    wanted = chart_part(chart)
    try:
        rewriting = _Rewriting(XmlLayout(text.encode()), base.source[1])
        found = rewriting.changed(base, wanted, chart.description)
        again = _said(found, chart.file)
        is_said = again == (wanted, chart.description)
        # A value that no chart can have, half-way through an edit, is read as one that it can.
        if not is_said and again != _said(write_chart(chart), chart.file):
            raise RewriteError(
                "this change cannot be made in the XML as it is written; make it in the XML itself"
            )
    except RewriteError:
        raise
    except ValueError as error:
        raise RewriteError(str(error)) from error
    return found


def _said(text: str, file: str) -> tuple[Part, str] | None:
    """Return all that a text says as a chart; values are compared as they are spelled."""
    chart, _problems = read_chart(text, file)
    return None if chart is None else (chart_part(chart), chart.description)


class _Rewriting:
    """The edits that make one chart of another."""

    def __init__(self, layout: XmlLayout, root: Element) -> None:
        self._layout = layout
        markups = zip(root.iter(), layout.elements, strict=True)
        self._markups: Mapping[int, Markup] = {id(element): markup for element, markup in markups}
        self._edits = Edits(layout, style_of(layout))

    def changed(self, base: Chart, wanted: Part, description: str) -> str:
        """Return the text with another chart in place of the one that it holds."""
        self._compare(chart_part(base), wanted, self._layout.root)
        about = description_edit(self._layout, self._edits.style, base.description, description)
        if about is not None:
            self._edits.replace(*about)
        self._edits.declare_extension()
        return self._edits.applied()

    def _compare(self, old: Part, new: Part, markup: Markup) -> None:
        """Collect the edits that make one element of another."""
        if old == new:
            return
        if old.tag != new.tag:
            self._edits.rename(markup, new.tag)
        self._compare_attributes(old, new, markup)
        for group in groups(old, new):
            self._compare_group(group, old, new, markup)
        self._edits.fill(markup, new.tag)

    def _compare_attributes(self, old: Part, new: Part, markup: Markup) -> None:
        is_retyped = old.attributes.get("type") != new.attributes.get("type")
        for name, value in new.attributes.items():
            span = markup.attributes.get(name)
            is_read_otherwise = is_retyped and name == "ext:default"
            if old.attributes.get(name) == value and not is_read_otherwise:
                continue
            if span is None:
                self._edits.add_attribute(markup, name, value)
                continue
            spelled = self._layout.data[span.value_start : span.value_end].decode()
            quote = chr(self._layout.data[span.value_end])
            text = _as_spelled(name, spelled, value, quote)
            self._edits.replace(span.value_start, span.value_end, text)
        for name in old.attributes.keys() - new.attributes.keys():
            if name in markup.attributes:
                span = markup.attributes[name]
                self._edits.replace(span.start, span.end, "")

    def _compare_group(self, group: str, old: Part, new: Part, markup: Markup) -> None:
        """Collect the edits that make the elements of one kind in an element others."""
        olds, news = in_group(old, group), in_group(new, group)
        if olds == news:
            return
        marks = [self._mark(part, markup) for part in olds]
        if None in marks:  # a chart without a datamodel; its model always has one
            olds, marks = [], []
        pairs = paired(group, olds, news)
        kept = kept_in_order(pairs)
        for index, mark in enumerate(marks):
            if index not in kept and mark is not None:
                self._edits.remove(mark)
        place, last = None, None
        staying = [marks[index] for index in sorted(kept)]
        for part, pair in zip(news, pairs, strict=True):
            mark = None if pair is None else marks[pair]
            if pair in kept and pair is not None and mark is not None:
                self._compare(olds[pair], part, mark)
                place, last = None, mark
                continue
            if place is None and last is not None:
                place = self._edits.after(last)
            elif place is None:
                place = self._first_place(group, old, markup, staying)
            if pair is None or mark is None:
                if part.tag != "datamodel" or part.children:
                    self._edits.add(part, place)
            else:
                self._edits.add_text(self._moved(olds[pair], part, mark), place)

    def _moved(self, old: Part, new: Part, markup: Markup) -> str:
        """Return the text of an element that goes to another place, with what changes in it."""
        outer, self._edits = self._edits, Edits(self._layout, self._edits.style)
        self._compare(old, new, markup)
        inner, self._edits = self._edits, outer
        self._edits.uses_extension |= inner.uses_extension
        return inner.applied(markup.start, markup.end)

    def _first_place(
        self, group: str, old: Part, markup: Markup, kept: Sequence[Markup | None]
    ) -> Place:
        """Return where the elements of a kind begin in an element."""
        first = next(iter(kept), None)
        if first is not None:
            return self._edits.before(first)
        order = list(groups(old, Part("", {}, [Part(group, {})])))
        before = [
            m for kind in order[: order.index(group)] for m in self._staying(old, kind, markup)
        ]
        if before:
            return self._edits.after(before[-1])
        behind = [
            m for kind in order[order.index(group) + 1 :] for m in self._staying(old, kind, markup)
        ]
        return self._edits.before(behind[0]) if behind else self._edits.inside(markup)

    def _staying(self, old: Part, group: str, markup: Markup) -> list[Markup]:
        """Return the elements of a kind right in an element that are not removed."""
        found = []
        for part in in_group(old, group):
            mark = self._mark(part, markup)
            while mark is not None and mark.parent is not markup:
                mark = mark.parent  # an outcome in <outcomes>
            if mark is not None and not self._edits.is_removed(mark):
                found.append(mark)
        return found

    def _mark(self, part: Part, markup: Markup) -> Markup | None:
        """Return where an element of the model stands."""
        if part.source is not None:
            return self._markups[id(part.source)]
        return next((child for child in markup.children if child.name == part.tag), None)


def _as_spelled(name: str, spelled: str, value: str, quote: str) -> str:
    """Return a new value, escaped, in the manner of the one that stood there."""
    if name == "ext:timeout_s" and _WHOLE.match(spelled):
        value = value.removesuffix(".0")
    text = escaped(value, quote)
    if name == "ext:on_error" and text == value and "&" not in spelled:
        return respelled(spelled, parse_routes(value))  # it may stand on several lines
    return text


# Change the comment that describes a chart, in place


def description_edit(
    layout: XmlLayout, style: Style, old: str, new: str
) -> tuple[int, int, str] | None:
    """Return the edit (start, end, text) that makes one description another; None: there is none.

    Lines that are added go below those that are there, which stay as they are.
    """
    if old == new:
        return None
    span = layout.description
    if span is None:
        return _added(layout, style, new)
    start, end = span
    newline = layout.newline(end)
    if not new:
        next_line = layout.next_line(end)
        if layout.begins_line(start) and next_line is not None:
            return layout.line_start(start), next_line, ""
        return start, end, ""
    if old and new.startswith(f"{old}\n"):
        text_end = start + len(layout.data[start : end - 3].rstrip())
        margin = _margin(layout, start, text_end)
        lines = new[len(old) + 1 :].split("\n")
        text = "".join(f"{newline}{margin}{line}".rstrip() for line in lines)
        return text_end, text_end, expect_xml(text)
    margin = " " * (start - layout.line_start(start) + len("<!-- "))
    return start, end, comment(new, newline + margin)


def _added(layout: XmlLayout, style: Style, new: str) -> tuple[int, int, str]:
    """Return the edit that adds a description where there is none."""
    root = layout.root
    newline, indent = layout.newline(root.head_end), ""
    lead = ""
    if layout.next_line(root.head_end) is not None:
        indent = layout.indentation(root.start) + style.indent
        lead = newline + indent
    text = comment(new, newline + indent + " " * len("<!-- "))
    return root.head_end, root.head_end, lead + text


def _margin(layout: XmlLayout, start: int, text_end: int) -> str:
    """Return the blanks before the lines of a comment, as far as all but the first have them."""
    lines = layout.data[start:text_end].decode().split("\n")[1:]
    blanks = [line[: len(line) - len(line.lstrip())] for line in lines if line.strip()]
    if blanks:
        return min(blanks, key=len)
    return " " * (start - layout.line_start(start) + len("<!-- "))
