"""How a page is arranged: which of its parts are shown, and in which order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

_HIDDEN = "-"


@dataclass(frozen=True)
class Part:
    """A part of a page; `area` is the column in which it stands."""

    title: str
    area: str
    is_shown: bool = True


def arranged(parts: Sequence[Part], text: str) -> tuple[Part, ...]:
    """Return parts as a text of `arrangement_text` has them.

    Parts that it does not name, as after an upgrade, follow; what it names and is none is left out.
    """
    known = {part.title: part for part in parts}
    titles = [word for word in text.split(",") if word.removeprefix(_HIDDEN) in known]
    named = {
        word.removeprefix(_HIDDEN): replace(
            known[word.removeprefix(_HIDDEN)], is_shown=not word.startswith(_HIDDEN)
        )
        for word in titles
    }
    return (*named.values(), *(part for part in parts if part.title not in named))


def arrangement_text(parts: Sequence[Part]) -> str:
    """Return an arrangement as a text that a browser can keep."""
    return ",".join(("" if part.is_shown else _HIDDEN) + part.title for part in parts)


def with_shown(parts: Sequence[Part], title: str, *, is_shown: bool) -> tuple[Part, ...]:
    """Return the parts with one shown or hidden."""
    return tuple(replace(p, is_shown=is_shown) if p.title == title else p for p in parts)


def moved(parts: Sequence[Part], title: str, step: int) -> tuple[Part, ...]:
    """Return the parts with one moved up (-1) or down (1) in its area; the first cannot go up."""
    found = list(parts)
    index = next(place for place, part in enumerate(found) if part.title == title)
    beside = [place for place, part in enumerate(found) if part.area == found[index].area]
    there = beside.index(index) + step
    if 0 <= there < len(beside):
        other = beside[there]
        found[index], found[other] = found[other], found[index]
    return tuple(found)
