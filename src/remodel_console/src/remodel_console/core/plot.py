"""Plots of the pages as options of Apache ECharts.

Colours are the page's CSS variables, so that plots follow its light and dark style; this needs the
SVG renderer of ECharts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

Options: TypeAlias = dict[str, Any]  # JSON; ECharts documents the keys

LEFT, RIGHT, BOTTOM = 48, 12, 22  # [pixels] margins of `series_plot`, for marks over it
_ROW = 22  # [pixels] of a bar with its name


def line_plot(names: Sequence[str], shares: Sequence[float]) -> Options:
    """Return shares, 0 to 1, as a line with a point for each name."""
    line = {"type": "line", "data": [round(100 * share, 1) for share in shares]}
    scale = {"max": 100, "interval": 50, "axisLabel": {"formatter": "{value} %"}}
    return _plot(_names(names), _values(scale), line, unit="%")


def bar_plot(names: Sequence[str], values: Sequence[float], unit: str) -> Options:
    """Return an upright bar for each name."""
    bars = {"type": "bar", "data": [round(value, 1) for value in values], "barMaxWidth": 28}
    scale = {"splitNumber": 2, "axisLabel": {"formatter": f"{{value}} {unit}"}}
    return _plot(_names(names), _values(scale), bars, unit=unit)


def series_plot(points: Sequence[tuple[float, float]], end: float) -> Options:
    """Return values over time as steps.

    Args:
        points: (time [s], value), in order.
        end: time at the right edge [s].
    """
    steps = {"type": "line", "step": "end", "data": [*map(list, points)], "showSymbol": False}
    time = {"min": 0, "max": end or 1.0, "splitNumber": 3, "splitLine": {"show": False}}
    time["axisLabel"] = {"formatter": "{value} s", "hideOverlap": True, "alignMaxLabel": "right"}
    return _plot(_values(time), _values({"splitNumber": 2}), steps)


def recent_plot(points: Sequence[tuple[float, float]], length_s: float) -> Options:
    """Return what was measured until now as a line.

    Args:
        points: (seconds before now, at most 0; value), in order.
        length_s: how long ago the left edge is [s].
    """
    line = {"type": "line", "data": [*map(list, points)], "showSymbol": False}
    time = {"min": -length_s, "max": 0, "interval": length_s / 3, "splitLine": {"show": False}}
    time["axisLabel"] = {"formatter": "{value} s", "alignMaxLabel": "right"}
    return _plot(_values(time), _values({"splitNumber": 2, "scale": True}), line)


def count_plot(counts: Sequence[tuple[str, int]]) -> Options:
    """Return a horizontal bar for each cause, with its name and number."""
    label = {"show": True, "position": "right", "color": "var(--ink)"}
    bars = {"type": "bar", "data": [count for _, count in counts], "barWidth": 13, "label": label}
    causes = _names([name for name, _ in counts])
    causes |= {"inverse": True, "axisLine": {"show": False}}
    causes["axisLabel"] |= {
        "interval": 0,
        "color": "var(--ink)",
        "width": 132,
        "overflow": "truncate",
    }
    plot = _plot(_values({"show": False}), causes, bars)
    plot["grid"] |= {"left": 140, "right": 30, "top": 0, "bottom": 0}
    return plot


def count_height(count: int) -> int:
    """Return the height of a `count_plot` [pixels]."""
    return _ROW * max(1, count)


def _plot(x_axis: Options, y_axis: Options, series: Options, unit: str = "") -> Options:
    accent = {"color": "var(--accent)"}
    return {
        "animation": False,
        "grid": {
            "left": LEFT,
            "right": RIGHT,
            "top": 10,
            "bottom": BOTTOM,
            "outerBoundsMode": "none",  # else long texts of an axis would move it
        },
        "xAxis": x_axis,
        "yAxis": y_axis,
        "series": [
            {"itemStyle": accent, "lineStyle": accent, "emphasis": {"disabled": True}} | series
        ],
        "tooltip": {
            "trigger": "axis",
            "confine": True,
            "backgroundColor": "var(--sheet)",
            "borderColor": "var(--line)",
            "textStyle": {"color": "var(--ink)", "fontSize": 12},
            "axisPointer": {"lineStyle": {"color": "var(--soft)"}},
            ":valueFormatter": f"value => `${{+value.toPrecision(3)}} {unit}`",
        },
    }


def _names(names: Sequence[str]) -> Options:
    """Return an axis of names, of which it shows as many as there is room for."""
    return _axis({"type": "category", "data": list(names), "splitLine": {"show": False}})


def _values(own: Options) -> Options:
    """Return an axis of numbers."""
    return _axis({"type": "value"} | own)


def _axis(own: Options) -> Options:
    line = {"lineStyle": {"color": "var(--line)"}}
    text = {"color": "var(--soft)", "fontSize": 12} | own.get("axisLabel", {})
    return (
        {"axisLine": line, "splitLine": line, "axisTick": {"show": False}}
        | own
        | {"axisLabel": text}
    )
