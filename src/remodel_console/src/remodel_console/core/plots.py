"""Plots as options of Apache ECharts, and which fields of topics can be plotted.

Colours are the page's CSS variables, so that plots follow its light and dark style; this needs the
SVG renderer of ECharts.

A plot is written as in Foxglove: the topic, a point, and the field, such as
`/cell/wrist/wrench.wrench.force.z` or `/joint_states.position[3]`. Names of topics have no points.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

Options: TypeAlias = dict[str, Any]  # JSON; ECharts documents the keys

# How texts, lines and what is shown at the pointer are drawn in all plots.
TEXT: Options = {"color": "var(--ink)", "fontSize": 12}
LINE: Options = {"lineStyle": {"color": "var(--line)"}}
TOOLTIP: Options = {
    "confine": True,
    "backgroundColor": "var(--sheet)",
    "borderColor": "var(--line)",
    "textStyle": TEXT,
}
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
            **TOOLTIP,
            "trigger": "axis",
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
    text = TEXT | {"color": "var(--soft)"} | own.get("axisLabel", {})
    return (
        {"axisLine": LINE, "splitLine": LINE, "axisTick": {"show": False}}
        | own
        | {"axisLabel": text}
    )


WINDOW_S = 60.0
_BIN_S = 0.2  # of whose samples the least and the greatest are kept, so that no peak is lost
_MOST_LISTED = 8  # fields that an error names
_LONGEST_ARRAY = 16  # elements of an array of fixed length that are offered one by one

_BYTES = ("byte", "char", "int8", "uint8")  # arrays of these are pictures and other data
_NUMBERS = (
    *_BYTES, "bool", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"
)  # fmt: skip
_OTHERS = ("string", "time", "duration")

# Returns (name, type) of each field of a message type, such as ("position", "float64[]").
FieldsOf = Callable[[str], Sequence[tuple[str, str]]]


def split_plot(plot: str) -> tuple[str, str]:
    """Return the topic and the field of a plot.

    Raises:
        ValueError: if it is not written as one.
    """
    topic, _, field = plot.partition(".")
    if not re.fullmatch(r"/[\w/]+", topic) or not re.fullmatch(r"[\w.\[\]]+", field):
        raise ValueError(
            f"'{plot}' is no plot; write /TOPIC.FIELD, such as /joint_states.position[3]"
        )
    return topic, field


def number_fields(kind: str, fields_of: FieldsOf) -> Iterator[str]:
    """Yield the fields of a message type that are numbers; of a list the first element."""
    for name, type_name in fields_of(kind):
        base, bracket, length = type_name.rstrip("]").partition("[")
        if base in _OTHERS or (bracket and base in _BYTES):
            continue
        count = min(int(length), _LONGEST_ARRAY) if length else 1
        for index in range(count):
            place = f"{name}[{index}]" if bracket else name
            if base in _NUMBERS:
                yield place
            else:
                yield from (f"{place}.{inner}" for inner in number_fields(base, fields_of))


def check_field(field: str, kind: str, known: Sequence[str]) -> None:
    """Refuse what is no number of a message type; an element of a list may have any index.

    Args:
        field: such as `position[3]`.
        kind: the message type.
        known: its `number_fields`.

    Raises:
        ValueError: if it is none.
    """
    if _shape(field) not in map(_shape, known):
        listed = ", ".join(known[:_MOST_LISTED]) or "none"
        more = f" and {len(known) - _MOST_LISTED} more" if len(known) > _MOST_LISTED else ""
        raise ValueError(f"{kind} has no number '{field}'; its numbers: {listed}{more}")


def _shape(field: str) -> str:
    return re.sub(r"\[\d+\]", "[]", field)


def number_in(message: object, field: str) -> float:
    """Return a field of a message.

    Raises:
        IndexError: if a list in it is shorter.
    """
    value = message
    for step in field.split("."):
        name, _, index = step.rstrip("]").partition("[")
        value = getattr(value, name)
        if index:
            value = value[int(index)]
    return float(value)  # type: ignore[arg-type]


class Samples:
    """The last minute of a value; of each fifth of a second its least and its greatest."""

    def __init__(self) -> None:
        self._bins: deque[list[tuple[float, float]]] = deque()

    def add(self, time_s: float, value: float) -> None:
        """Add a sample, not before the last one; NaN and infinity are left out."""
        if not math.isfinite(value):
            return
        sample = (time_s, value)
        if self._bins and time_s // _BIN_S == self._bins[-1][0][0] // _BIN_S:
            samples = [*self._bins[-1], sample]
            ends = {min(samples, key=lambda s: s[1]), max(samples, key=lambda s: s[1])}
            self._bins[-1] = sorted(ends)
        else:
            self._bins.append([sample])
            self._forget(time_s)

    def _forget(self, now_s: float) -> None:
        while self._bins and self._bins[0][-1][0] < now_s - WINDOW_S:
            self._bins.popleft()

    def points(self, now_s: float) -> list[tuple[float, float]]:
        """Return (seconds before now, at most 0; value) of the samples of the last minute."""
        self._forget(now_s)
        return [(round(t - now_s, 2), value) for each in tuple(self._bins) for t, value in each]
