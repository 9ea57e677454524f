"""Pieces of source text, cut out by patterns and brackets as the App does."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator

_OPEN, _CLOSE = "([{", ")]}"
_QUOTED = re.compile(r"\s*(?:'([^']*)'|\"([^\"]*)\")\s*\Z")
_TOKEN = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"|[\[\](){},'\"]", re.DOTALL)
MANUAL_TAGS = ("IMPORT", "INIT", "CREATE", "FUNC")


class AppLoadError(ValueError):
    """The App cannot load the file."""


def manual_sections(text: str) -> dict[str, str]:
    """Return the text between the tags of each manual section, '' for one without tags.

    Raises:
        AppLoadError: if a section begins and does not end exactly once after that.
    """
    found = {}
    for tag in MANUAL_TAGS:
        begin, end = f"# [MANUAL_{tag}]", f"# [/MANUAL_{tag}]"
        if text.count(begin) != 1:
            found[tag] = ""  # without tags, or with several, nothing is extracted
            continue
        rest = text.partition(begin)[2]
        if rest.count(end) != 1:
            raise AppLoadError(f"'{begin}' is not followed by exactly one '{end}'")
        found[tag] = rest.partition(end)[0]
    return found


def without_manual(text: str) -> str:
    """Return the text without what stands in manual sections."""
    for tag in MANUAL_TAGS:
        begin, end = f"# [MANUAL_{tag}]", f"# [/MANUAL_{tag}]"
        if text.count(begin) == 1:
            head, _, rest = text.partition(begin)
            text = f"{head}{begin}{end}{rest.partition(end)[2]}"
    return text


def section(text: str, head: str) -> str:
    """Return a method's text: up to the next ` def `, even in a comment."""
    rest = text.partition(head)[2]
    end = re.search(r"\sdef\s", rest)
    return rest[: end.start()] if end else rest


def bracketed(text: str, start: int) -> str | None:
    """Return what stands between the bracket at `start` and its partner; None without one."""
    depth = 0
    for place, mark in _marks(text, start):
        depth += (mark in _OPEN) - (mark in _CLOSE)
        if depth == 0:
            return text[start + 1 : place]
    return None


def items(text: str) -> list[str]:
    """Return the parts between commas outside of brackets and quotes, but for empty ones."""
    return [part for part in parts(text) if part]


def parts(text: str) -> list[str]:
    """Return the parts between commas outside of brackets and quotes, without outer blanks.

    What is empty is one empty part, and so is what follows a trailing comma.
    """
    cuts, depth = [-1], 0
    for place, mark in _marks(text):
        depth += (mark in _OPEN) - (mark in _CLOSE)
        if mark == "," and depth == 0:
            cuts.append(place)
    cuts.append(len(text))
    return [text[a + 1 : b].strip() for a, b in itertools.pairwise(cuts)]


def is_balanced(text: str) -> bool:
    """Return whether all brackets and quotes of a value close."""
    open_ones = []
    for _place, mark in _marks(text):
        if mark in _OPEN:
            open_ones.append(_CLOSE[_OPEN.index(mark)])
        elif mark != "," and (not open_ones or open_ones.pop() != mark):
            return False
    return not open_ones


def unquoted(text: str) -> str | None:
    """Return the text of a quoted string, None for anything else."""
    found = _QUOTED.match(text)
    return None if found is None else found[1] if found[1] is not None else found[2]


def names(text: str) -> list[str] | None:
    """Return the strings of a list `['a', "b"]`, None for anything else."""
    inner = re.fullmatch(r"\s*\[(.*)\]\s*", text, re.DOTALL)
    if inner is None:
        return None
    found = [unquoted(item) for item in items(inner[1])]
    return None if None in found else [name for name in found if name is not None]


def pairs(text: str) -> dict[str, str]:
    """Return the entries of `'key': value, ...`; those whose key is not quoted are left out."""
    found = {}
    for item in items(text):
        entry = re.match(r"('[^']*'|\"[^\"]*\")\s*:\s*(.*)", item, re.DOTALL)
        if entry:
            found[entry[1][1:-1]] = entry[2].strip()
    return found


def _marks(text: str, start: int = 0) -> Iterator[tuple[int, str]]:
    """Yield place and letter of brackets and commas outside of quotes, and of quotes left open."""
    for found in _TOKEN.finditer(text, start):
        if len(found[0]) == 1:
            yield found.start(), found[0]
