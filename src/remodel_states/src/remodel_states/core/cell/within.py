"""What is out of its limits: how it is worded."""

from __future__ import annotations

from collections.abc import Iterator

# Rounding of decimal numbers, in any unit.
TOLERANCE = 1e-9


def within(
    what: str, value: float, limits: tuple[float, float], unit: str = "m", remedy: str = ""
) -> Iterator[str]:
    """Yield a sentence if a value is out of its limits: by how much, and what would change it."""
    low, high = limits
    if low - TOLERANCE <= value <= high + TOLERANCE:
        return
    off, too = (low - value, "little") if value < low else (value - high, "much")
    yield (
        f"{what} is {value:.4g} {unit}, {off:.3g} {unit} too {too}; allowed: {low:.4g} to "
        f"{high:.4g} {unit}".replace("  ", " ")
        .replace(" ;", ";")
        .rstrip()
        + (f": {remedy}" if remedy else "")
    )
