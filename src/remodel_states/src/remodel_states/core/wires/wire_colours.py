"""Colours of wires by their codes, as sRGB in 0 to 1.

A wire of several colours has their codes one after another, the colour of its ground first: WHBU is
white with a blue stripe. Green-and-yellow is GNYE, in whichever order it is written.
"""

from __future__ import annotations

from collections.abc import Iterable

Rgb = tuple[float, float, float]

# Chosen near RAL cable colours; none comes near the ferrules' magenta in hue and saturation. The
# codes are those of IEC 60757, those that WireViz adds (OL to SN), and DB for the dark blue of
# control voltages, which has no code there.
WIRE_RGB: dict[str, Rgb] = {
    "BK": (0.06, 0.06, 0.07),
    "BN": (0.40, 0.22, 0.10),
    "RD": (0.80, 0.06, 0.05),
    "OG": (0.95, 0.45, 0.05),
    "YE": (0.95, 0.80, 0.08),
    "GN": (0.08, 0.50, 0.16),
    "BU": (0.08, 0.22, 0.75),
    "VT": (0.36, 0.18, 0.60),
    "GY": (0.42, 0.44, 0.46),
    "WH": (0.97, 0.97, 0.96),
    "PK": (0.95, 0.62, 0.66),
    "TQ": (0.05, 0.62, 0.62),
    "GD": (0.79, 0.63, 0.15),
    "SR": (0.66, 0.66, 0.68),
    "DB": (0.05, 0.12, 0.36),
    "OL": (0.42, 0.44, 0.14),
    "LB": (0.40, 0.68, 0.90),
    "BG": (0.82, 0.72, 0.53),
    "IV": (0.93, 0.90, 0.76),
    "SL": (0.35, 0.40, 0.45),
    "CU": (0.72, 0.45, 0.20),
    "SN": (0.72, 0.72, 0.70),
}
GREEN_AND_YELLOW = "GNYE"
# The colours of most wires, which a camera distinguishes: the others are shades of them.
DISTINCT_COLOURS = (
    *("BK", "BN", "RD", "OG", "YE", "GN", "BU", "VT", "GY", "WH", "PK", "TQ"),
    GREEN_AND_YELLOW,
)
# Letters of a code.
_CODE = 2


def joined_colours(codes: Iterable[str]) -> str:
    """Return the colour of a wire with the colours of those codes, the ground's first."""
    colour = "".join(dict.fromkeys(codes))
    return GREEN_AND_YELLOW if colour == "YEGN" else colour


def codes_of(colour: str) -> tuple[str, ...]:
    """Return the codes of a wire's colours, known or not."""
    return tuple(colour[i : i + _CODE] for i in range(0, len(colour), _CODE))


def is_colour(colour: str) -> bool:
    """Return whether a wire may have that colour: one known code or several."""
    return bool(colour) and all(code in WIRE_RGB for code in codes_of(colour))


def rgbs_of(colour: str) -> tuple[Rgb, ...]:
    """Return what the colours of a wire look like, that of its ground first."""
    return tuple(WIRE_RGB[code] for code in codes_of(colour))


def hex_colours(colour: str) -> tuple[str, ...]:
    """Return the colours of a wire as HTML has them, such as "#1438bf"; grey for unknown ones."""
    unknown = (0.5, 0.5, 0.5)
    return tuple(
        "#" + "".join(f"{round(255 * level):02x}" for level in WIRE_RGB.get(code, unknown))
        for code in codes_of(colour) or ("",)
    )


def nearest_code(rgb: Rgb) -> str:
    """Return the distinct single colour that is nearest to an RGB value in 0 to 1."""
    single = [code for code in DISTINCT_COLOURS if code in WIRE_RGB]
    return min(
        single,
        key=lambda code: sum((a - b) ** 2 for a, b in zip(rgb, WIRE_RGB[code], strict=True)),
    )
