"""Drawings of charts, made once each."""

from __future__ import annotations

import re
from functools import lru_cache

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.export.draw import chart_to_dot
from flexbe_synthesizer.edge.graphviz import dot_picture
from flexbe_synthesizer.errors import DrawingError
from remodel_console.core.editor.drawing import page_svg
from remodel_console.errors import CommandError

_KEPT = 32  # drawings
_DIRECTIONS = ("TB", "LR")
_SIZE = re.compile(r'viewBox="0\.00 0\.00 ([\d.]+) ([\d.]+)"')


def picture(chart: Chart, room: tuple[float, float]) -> str:
    """Return the drawing of a chart as an SVG for the page, in the direction that shows it larger.

    Args:
        chart: what to draw.
        room: width and height that the page has for it on a common screen [pixels].

    Raises:
        CommandError: if Graphviz is not installed or fails.
    """
    try:
        drawings = (_svg(chart_to_dot(chart, direction=direction)) for direction in _DIRECTIONS)
        return max(drawings, key=lambda svg: _scale(svg, room))
    except DrawingError as error:
        raise CommandError(f"the chart cannot be drawn: {error}") from error


@lru_cache(maxsize=_KEPT)
def _svg(dot: str) -> str:
    return page_svg(dot_picture(dot, ".svg").decode())


def _scale(svg: str, room: tuple[float, float]) -> float:
    """Return how large a drawing is shown if all of it is."""
    found = _SIZE.search(svg)
    if found is None:
        return 0.0
    return min(room[0] / float(found[1]), room[1] / float(found[2]))
