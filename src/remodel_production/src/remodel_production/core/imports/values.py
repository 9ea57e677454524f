"""Values as designs write them: quantities, colours, assumptions; the account of an import."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.production import Order
from remodel_run.findings import UNKNOWN_COLOUR, Account, LeftOut
from remodel_states.core.wires import WIRE_RGB, joined_colours, nearest_code

__all__ = ["Account", "Imported", "LeftOut"]


@dataclass(frozen=True)
class Imported:
    """An order, and the account of how it came about."""

    order: Order
    account: Account

    def assuming(self, lines: Iterable[str]) -> Imported:
        """Return it with a line for each thing assumed besides, in the order and the account."""
        order, account, more = self.order, self.account, tuple(lines)
        return Imported(
            replace(order, notes=(*order.notes, *more)),
            replace(account, assumptions=(*account.assumptions, *more)),
        )


# Copper of more than 1000 mm2 or a wire of more than 1 km is a slip of the pen.
_MOST_SECTION_MM2 = 1000.0
_MOST_LENGTH_M = 1000.0

_LENGTH_UNITS_M = {
    **{"mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0},
    **{"in": 0.0254, '"': 0.0254, "inch": 0.0254, "ft": 0.3048, "'": 0.3048},
}
_NUMBER = r"[-+]?[\d.,]*\d"
_AWG = re.compile(
    r"awg\s*#?\s*(\d+(?:/0)?)|#?\s*(\d+(?:/0)?)\s*(?:awg|ga)|^\s*#\s*(\d+(?:/0)?)\s*$",
    re.IGNORECASE,
)
_MM2 = re.compile(rf"({_NUMBER})\s*(?:mm\s*(?:2|²|\^2)?|qmm|sqmm)(?![a-z])", re.IGNORECASE)
_LENGTH = re.compile(rf"({_NUMBER})\s*([a-z]+|\"|')?", re.IGNORECASE)


def number(text: str) -> float | None:
    """Return a number with a decimal point or comma, or None if the text is none.

    Where both occur, the last one is the decimal sign; several of one kind are separators.
    """
    text = text.strip().replace("\N{NO-BREAK SPACE}", "").replace(" ", "")
    decimal = max(".,", key=text.rfind)
    if text.count(decimal) > 1:
        decimal = ""
    for sign in ".,":
        if sign != decimal:
            text = text.replace(sign, "")
    if not re.fullmatch(r"[-+]?(\d+[.,]?\d*|[.,]\d+)(e[-+]?\d{1,2})?", text, re.IGNORECASE):
        return None
    return float(text.replace(",", "."))


def section_mm2(text: str, unit: str = "mm2") -> float | None:
    """Return the section [mm^2] that a text gives, or None if it gives none.

    Args:
        text: such as "1,5 mm²", "AWG 14", "#14" or "0.75".
        unit: of a number without one, "mm2" or "awg".
    """
    if match := _AWG.search(text):
        return awg_mm2(match[1] or match[2] or match[3])
    if match := _MM2.search(text):
        return _within(number(match[1]), _MOST_SECTION_MM2)
    if unit == "awg":
        return awg_mm2(text.strip()) if re.fullmatch(r"\d+(/0)?", text.strip()) else None
    return _within(number(text), _MOST_SECTION_MM2)


def awg_mm2(gauge: str) -> float | None:
    """Return the section [mm^2] of an American wire gauge such as "14" or "2/0" (ASTM B258)."""
    n = 1 - int(gauge.split("/")[0]) if "/" in gauge else int(gauge)
    if not -3 <= n <= 40:
        return None
    diameter_mm = 0.127 * 92 ** ((36 - n) / 39)
    return float(f"{math.pi / 4 * diameter_mm**2:.3g}")


def length_m(text: str, unit: str = "m") -> float | None:
    """Return the length [m] that a text gives, or None if it gives none.

    Args:
        text: such as "350", "0,35 m" or "14 in".
        unit: of a number without one.
    """
    match = _LENGTH.fullmatch(text.strip())
    if match is None:
        return None
    scale = _LENGTH_UNITS_M.get((match[2] or unit).lower())
    value = number(match[1])
    return None if scale is None or value is None else _within(value * scale, _MOST_LENGTH_M)


def is_length_unit(unit: str) -> bool:
    """Return whether a length may be given in that unit."""
    return unit in _LENGTH_UNITS_M


def _within(value: float | None, most: float) -> float | None:
    return None if value is None or not 0 < value <= most else round(value, 9)


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


_SPLICE = re.compile(r"splice|splei(?:ss|ß)|[ée]pissure|giunzione|empalme", re.IGNORECASE)


def names_splice(*texts: str) -> bool:
    """Return whether one of some texts names a splice, in one of five languages."""
    return any(_SPLICE.search(text) for text in texts)


class Assumptions:
    """One line for each assumption, in the order of the file."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self.lines: list[str] = []

    def add(self, line: str) -> None:
        """Note an assumption."""
        self.lines.append(line)

    def colour(self, text: str, source: str) -> str:
        """Return the code of a colour, or the default for one that is not known."""
        code = colour_code(text, self._catalogue) if text else None
        if code is not None:
            return code
        code = colour_without_shade(text, self._catalogue)
        if code is not None:
            self.add(f"{source}: colour {text!r} read as {code}")
            return code
        default = self._catalogue.default_colour
        found = f"{text!r} {UNKNOWN_COLOUR}" if text else "not given"
        self.add(f"{source}: colour {found}, {default} taken")
        return default

    def section(self, text: str, source: str, unit: str = "mm2") -> float:
        """Return a section [mm^2], or the default for one that is not understood."""
        section = section_mm2(text, unit) if text else None
        if section is not None:
            return section
        default = self._catalogue.default_section
        found = f"{text!r} not understood" if text else "not given"
        self.add(f"{source}: section {found}, {default:g} mm2 taken")
        return default
