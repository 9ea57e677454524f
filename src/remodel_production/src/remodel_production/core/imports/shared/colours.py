"""Colours of wires as design files write them, to the codes that wires have."""

from __future__ import annotations

import re

from remodel_production.core.catalogue import Catalogue
from remodel_states.core.wires.wire_colours import WIRE_RGB, joined_colours, nearest_code

_SEPARATORS = re.compile(r"[\s/+&;,_.:|()-]+")
_GAUGE = re.compile(r"\d+(awg|mm2|mm²)?|awg")  # in names of layers: BLK_14AWG
_RGB = re.compile(r"#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})")
# Words beside the colours of a wire with a stripe: "yellow w/ red"; but "W/RD" is white and red.
_JOINING = re.compile(r"(?<=\s)w/|\b(?:with|mit|avec|con|stripes?|str|tracer|streifen)\b")
# What a name of a colour may have besides: "bright red", "hellgrau", "gris claro".
_SHADES = re.compile(
    r"\b(?:light|dark|bright|hell|dunkel|clair|claire|"
    r"fonc\u00e9|fonc\u00e9e|chiaro|chiara|scuro|scura|claro|clara|oscuro|oscura|lt|dk)(?=\W|$)|"
    r"\b(?:hell|dunkel)(?=\w{3})"
)
# The shortest name within names that follow each other without a sign: WHBU, WHTBLU, gelbgrün.
_SHORTEST = 2
# A wire has no more colours.
_MOST_COLOURS = 3


def colour_code(text: str, catalogue: Catalogue) -> str | None:
    """Return the code of a colour, or None if it is not known.

    Args:
        text: a code, a name, an RGB value, or several of them, the ground's first, such as "GNYE",
            "green-yellow", "sw/vi", "WHTBLU", "white with blue stripe" or "#ff0000".
        catalogue: that knows names and values.
    """
    names = {**catalogue.colour_names, **catalogue.colour_values}
    return _colour(" ".join(text.lower().split()), _Names(names))


def colour_without_shade(text: str, catalogue: Catalogue) -> str | None:
    """Return the code of a colour of which a shade is named, such as "light blue"; None if none.

    The colour of an RGB value is the nearest one.
    """
    text = " ".join(text.lower().split())
    if value := _RGB.fullmatch(text):
        red, green, blue = (int(level, 16) / 255 for level in value.groups())
        return nearest_code((red, green, blue))
    plain = " ".join(_SHADES.sub(" ", text).split())
    return colour_code(plain, catalogue) if plain and plain != text else None


class _Names(dict[str, str]):
    """Codes by what stands for them, in lower case; a code of the table stands for itself."""

    def __missing__(self, text: str) -> str | None:
        return text.upper() if text.upper() in WIRE_RGB else None


def _colour(text: str, names: _Names) -> str | None:
    whole = names[text]
    if whole is not None:
        return whole
    parts = [part for part in _SEPARATORS.split(_JOINING.sub(" ", text)) if part]
    parts = [part for part in parts if not _GAUGE.fullmatch(part)]
    found: list[str] = []
    while parts:
        # Names may be of two words: "dark blue".
        length = 2 if len(parts) > 1 and names[" ".join(parts[:2])] else 1
        code = names[" ".join(parts[:length])] or _run_together(parts[0], names)
        if code is None:
            return None
        found.append(code)
        parts = parts[length:]
    codes = [code[i : i + 2] for code in found for i in range(0, len(code), 2)]
    return joined_colours(codes) if 1 <= len(codes) <= _MOST_COLOURS else None


def _run_together(text: str, names: _Names) -> str | None:
    """Return the colours of the fewest names that a text is without signs; None if unclear."""
    readings = _readings(text, names, _MOST_COLOURS)
    fewest = min(map(len, readings), default=0)
    found = {joined_colours(codes) for codes in readings if len(codes) == fewest}
    return found.pop() if len(found) == 1 else None


def _readings(text: str, names: _Names, most: int) -> list[tuple[str, ...]]:
    """Return each way in which a text is names that follow each other, at most so many."""
    if not text:
        return [()]
    if most == 0:
        return []
    return [
        (code, *rest)
        for end in range(_SHORTEST, len(text) + 1)
        for code in [names[text[:end]]]
        if code is not None
        for rest in _readings(text[end:], names, most - 1)
    ]
