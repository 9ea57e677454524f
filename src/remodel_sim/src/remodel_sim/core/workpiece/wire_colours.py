"""Colours of wires by their IEC 60757 codes, as sRGB in 0 to 1."""

Rgb = tuple[float, float, float]

# Chosen near RAL cable colours; none comes near the ferrules' magenta in hue and saturation.
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
    "GNYE": (0.45, 0.70, 0.08),
}

# Stripes of a two-coloured wire, drawn link by link.
GREEN_AND_YELLOW: tuple[Rgb, Rgb] = (WIRE_RGB["GN"], WIRE_RGB["YE"])

# The collar that covers each ferrule: a hue that no wire has, so that loose ends are found among
# wires of any colour.
FERRULE_RGB: Rgb = (0.95, 0.02, 0.62)

# The mounting plate, near RAL 7035 (light grey).
PLATE_RGB: Rgb = (0.80, 0.82, 0.80)
