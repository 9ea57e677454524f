"""Colours of wires as design files write them, to IEC 60757 codes."""

from __future__ import annotations

import re

from remodel_production.core.catalogue import Catalogue

_SEPARATORS = re.compile(r"[\s/+;,_.:-]+")
_GAUGE = re.compile(r"\d+(awg|mm2|mm²)?|awg")  # in names of layers: BLK_14AWG
_CODE = 2  # letters of a code
# What a name of a colour may have besides: "yellow w/ red", "dunkelblau", "gris claro".
_SHADES = re.compile(
    r"\b(?:w/|with|mit|avec|con|stripe|tracer|streifen|light|dark|bright|hell|dunkel|clair|claire|"
    r"fonc\u00e9|fonc\u00e9e|chiaro|chiara|scuro|scura|claro|clara|oscuro|oscura|lt|dk)(?=\W|$)|"
    r"\b(?:hell|dunkel)(?=\w{3})"
)


def colour_code(text: str, catalogue: Catalogue) -> str | None:
    """Return the code of a colour, or None if it is not known.

    Args:
        text: a code, a name, an RGB value, or several of them, such as "GNYE", "green-yellow",
            "sw/vi" or "#ff0000".
        catalogue: that knows names and values.
    """
    text = text.strip().lower()
    whole = _single(text, catalogue)
    if whole is not None:
        return whole
    parts = [part for part in _SEPARATORS.split(text) if part]
    parts = [part for part in parts if not _GAUGE.fullmatch(part)]
    if len(parts) == 1 and len(text) % _CODE == 0:
        parts = [text[i : i + _CODE] for i in range(0, len(text), _CODE)]
    codes = [_single(part, catalogue) for part in parts]
    known = [code for code in codes if code is not None]
    return "".join(known) if known and len(known) == len(codes) else None


def colour_without_shade(text: str, catalogue: Catalogue) -> str | None:
    """Return the code of a colour of which a shade is named, such as "light blue"; None if none."""
    plain = " ".join(_SHADES.sub(" ", text.lower()).split())
    return colour_code(plain, catalogue) if plain and plain != text.lower() else None


def _single(text: str, catalogue: Catalogue) -> str | None:
    if text in catalogue.colour_values:
        return catalogue.colour_values[text]
    if text in catalogue.colour_names:
        return catalogue.colour_names[text]
    return text.upper() if text.upper() in catalogue.colour_codes else None
