"""Quantities as design files write them: numbers, sections, lengths."""

from __future__ import annotations

import math
import re

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
