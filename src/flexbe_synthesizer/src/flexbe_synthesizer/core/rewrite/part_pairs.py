"""Which element of a chart became which when the chart was changed."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Hashable, Iterator, Sequence
from itertools import takewhile

from flexbe_synthesizer.core.chart.chart_writer import Part

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
    head = _same(olds, news)
    tail = min(_same(olds[::-1], news[::-1]), min(len(olds), len(news)) - head)
    middle = _paired(group, olds[head : len(olds) - tail], news[head : len(news) - tail])
    return [
        *range(head),
        *(None if index is None else head + index for index in middle),
        *range(len(olds) - tail, len(olds)),
    ]


def _same(olds: Sequence[Part], news: Sequence[Part]) -> int:
    """Return how many elements are equal at the beginning."""
    pairs = zip(olds, news, strict=False)
    return sum(1 for _pair in takewhile(lambda pair: pair[0] == pair[1], pairs))


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
