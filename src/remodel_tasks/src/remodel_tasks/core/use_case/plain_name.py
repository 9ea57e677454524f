"""Names of designs as charts can carry them."""

from __future__ import annotations

import hashlib
import re

from flexbe_synthesizer.core.chart.names import is_name

_HASH_DIGITS = 6
_NO_WORD = re.compile(r"\W+", re.ASCII)


def plain_name(name: str) -> str:
    """Return a name in letters, digits and `_`; one that is changed ends in digits of its hash.

    So `24#2` and `24+2` stay apart, in charts and in the files of their behaviors.
    """
    plain = _NO_WORD.sub("_", name)
    if plain == name and is_name(f"the {name}"):
        return name
    return f"{plain}_{hashlib.sha256(name.encode()).hexdigest()[:_HASH_DIGITS]}"


def take_name(name: str, taken: set[str]) -> str:
    """Return the name, with a number if it is taken, and take it.

    Names that differ in capitals alone are one: the files of behaviors have names in lower case.
    """
    found, number = name, 1
    while found.lower() in taken:
        number += 1
        found = f"{name}#{number}"
    taken.add(found.lower())
    return found
