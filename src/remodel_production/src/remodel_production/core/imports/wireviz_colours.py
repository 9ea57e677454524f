"""Colour codes of multi-core cables that WireViz files name."""

from __future__ import annotations

from itertools import cycle, islice

# DIN 47100, cores 1 to 44.
_DIN = [
    *("WH", "BN", "GN", "YE", "GY", "PK", "BU", "RD", "BK", "VT", "GYPK", "RDBU", "WHGN", "BNGN"),
    *("WHYE", "YEBN", "WHGY", "GYBN", "WHPK", "PKBN", "WHBU", "BNBU", "WHRD", "BNRD", "WHBK"),
    *("BNBK", "GYGN", "YEGY", "PKGN", "YEPK", "GNBU", "YEBU", "GNRD", "YERD", "GNBK", "YEBK"),
    *("GYBU", "PKBU", "GYRD", "PKRD", "GYBK", "PKBK", "BUBK", "RDBK"),
]
# The 25-pair colour code: five tip colours, each with five ring colours.
_TIPS, _RINGS = ("WH", "RD", "BK", "YE", "VT"), ("BU", "OG", "GN", "BN", "SL")

_CODES = {
    "DIN": _DIN,
    "IEC": ["BN", "RD", "OG", "YE", "GN", "BU", "VT", "GY", "WH", "BK"],
    "BW": ["BK", "WH"],
    "TEL": [code for tip in _TIPS for ring in _RINGS for code in (ring + tip, tip + ring)],
    "TELALT": [
        code
        for tip in _TIPS
        for ring in _RINGS
        for code in (tip + ring, ring if tip == "WH" else ring + tip)
    ],
    "T568A": ["WHGN", "GN", "WHOG", "BU", "WHBU", "OG", "WHBN", "BN"],
    "T568B": ["WHOG", "OG", "WHGN", "BU", "WHBU", "GN", "WHBN", "BN"],
}
COLOUR_CODES = tuple(_CODES)


def core_colours(code: str, count: int) -> list[str]:
    """Return the colours of the first cores by a code of COLOUR_CODES; they begin again."""
    return list(islice(cycle(_CODES[code]), count))
