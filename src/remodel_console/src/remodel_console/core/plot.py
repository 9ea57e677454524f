"""Small charts as SVG, in the colours of the page."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

WIDTH, HEIGHT = 280, 110  # [units of the drawing]
_LEFT, _BOTTOM, _TOP = 42, 20, 8
_ROW = 22  # of a bar with its name
_NAME, _BAR = 165, 85


def line_plot(label: str, names: Sequence[str], values: Sequence[float], top: float) -> str:
    """Return a line over things in a row, `top` being the value at the upper edge."""
    places = _places(len(values))
    points = [(x, _height(value, top)) for x, value in zip(places, values, strict=True)]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    dots = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" class="mark"><title>{escape(name)}: '
        f"{value:.0%}</title></circle>"
        for (x, y), name, value in zip(points, names, values, strict=True)
    )
    inside = f'<polyline points="{path}" class="line"/>{dots}'
    return _frame(label, inside + _names(names, places), ("0 %", f"{top:.0%}"))


def series_plot(label: str, points: Sequence[tuple[float, float]], end: float) -> str:
    """Return values over time as steps.

    Args:
        label: what the values are.
        points: (time [s], value), in order.
        end: time at the right edge [s].
    """
    values = [value for _, value in points]
    low, high = min([0.0, *values]), max([0.0, *values])
    top = high - low or 1.0
    path = ""
    for time_s, value in points:
        x, y = WIDTH * series_share(time_s, end), _height(value - low, top)
        path += f"H{x:.1f}V{y:.1f}" if path else f"M{x:.1f},{y:.1f}"
    inside = f'<path d="{path}" class="line"/>' if path else ""
    return _frame(label, inside, (f"{low:.3g}", f"{low + top:.3g}"))


def series_share(time: float, end: float) -> float:
    """Return where a time [s] is in `series_plot`, as a share of its width from the left."""
    return (_LEFT + (WIDTH - _LEFT) * time / (end or 1.0)) / WIDTH


def bar_plot(label: str, names: Sequence[str], values: Sequence[float], unit: str) -> str:
    """Return an upright bar for each thing in a row."""
    top = max([*values, 1.0])
    places = _places(len(values))
    width = min(28.0, 0.7 * (WIDTH - _LEFT) / max(1, len(values)))
    bars = "".join(
        f'<rect x="{x - width / 2:.1f}" y="{_height(value, top):.1f}" width="{width:.1f}" '
        f'height="{_height(0, top) - _height(value, top):.1f}" class="bar"><title>{escape(name)}: '
        f"{value:.0f} {escape(unit)}</title></rect>"
        for x, name, value in zip(places, names, values, strict=True)
    )
    return _frame(label, bars + _names(names, places), (f"0 {unit}", f"{top:.0f} {unit}"))


def count_plot(label: str, counts: Sequence[tuple[str, int]]) -> str:
    """Return a lying bar for each cause, with its name and number."""
    top = max((count for _, count in counts), default=1)
    rows = []
    for row, (name, count) in enumerate(counts):
        y = row * _ROW
        rows.append(
            f'<text x="0" y="{y + 14}" class="name">{escape(name)}</text>'
            f'<rect x="{_NAME}" y="{y + 4}" width="{_BAR * count / top:.1f}" height="13" '
            f'class="bar"/><text x="{_NAME + 6 + _BAR * count / top:.1f}" y="{y + 15}">{count}'
            "</text>"
        )
    height = max(_ROW, _ROW * len(counts))
    return _svg(label, "".join(rows), height)


def _places(count: int) -> list[float]:
    """Return where things in a row stand from left to right."""
    step = (WIDTH - _LEFT - 10) / max(1, count)
    return [_LEFT + step * (index + 0.5) for index in range(count)]


def _height(value: float, top: float) -> float:
    return HEIGHT - _BOTTOM - (HEIGHT - _BOTTOM - _TOP) * value / top


def _names(names: Sequence[str], places: Sequence[float]) -> str:
    """Return as many names as there is room for."""
    every = -(-len(names) // 10) or 1
    return "".join(
        f'<text x="{x:.1f}" y="{HEIGHT - 4}" text-anchor="middle">{escape(name)}</text>'
        for index, (name, x) in enumerate(zip(names, places, strict=True))
        if index % every == 0
    )


def _frame(label: str, inside: str, ends: tuple[str, str]) -> str:
    lines = "".join(
        f'<line x1="{_LEFT}" y1="{y}" x2="{WIDTH}" y2="{y}" class="grid"/>'
        f'<text x="{_LEFT - 4}" y="{y + 4}" text-anchor="end">{escape(text)}</text>'
        for y, text in zip((HEIGHT - _BOTTOM, _TOP), ends, strict=True)
    )
    return _svg(label, lines + inside, HEIGHT)


def _svg(label: str, inside: str, height: int) -> str:
    return (
        f'<svg class="plot" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'aria-label="{escape(label)}">{inside}</svg>'
    )
