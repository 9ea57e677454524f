"""Draw a plan as SVG: what each arm does when, and the panel with its wires in their order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from remodel_tasks.core.plan.checker import Verdict
from remodel_tasks.core.problem.problem import (
    TICKS_PER_S,
    Action,
    ActionKind,
    End,
    Plan,
    Point,
    Problem,
)

# Pixels of the drawing.
_WIDTH = 1600
_MARGIN = 40
_LANE = 30
_AXIS = 20
_LEGEND = 24

_LABELS_ON_AXIS = 10
# From left to right in the legend; one colour for each kind of action.
_FILLS = {
    ActionKind.CHANGE_TOOL: "#7f7f7f",
    ActionKind.PICK: "#1f77b4",
    ActionKind.LOCATE: "#bcbd22",
    ActionKind.INSERT: "#2ca02c",
    ActionKind.ROUTE: "#ff9f4a",
    ActionKind.HAND_OVER: "#9467bd",
    ActionKind.FIX: "#17becf",
    ActionKind.EXTRACT: "#d62728",
}
_ARM_STROKES = ("#1f4e9c", "#b3400e")


@dataclass(frozen=True)
class _View:
    """The part of the drawing that shows the panel: what is where, x to the right and y up."""

    left_mm: int
    top_mm: int
    scale: float
    top: float

    def place(self, point: Point) -> tuple[float, float]:
        """Return where a position of the panel is drawn."""
        x = _MARGIN + self.scale * (point[0] - self.left_mm)
        return x, self.top + self.scale * (self.top_mm - point[1])


def draw_plan(problem: Problem, plan: Plan, verdict: Verdict) -> str:
    """Return the SVG of a valid plan, with the verdict on it."""
    chart_height = _MARGIN + _LANE * len(problem.arms) + _AXIS + _LEGEND
    points = [terminal.position_mm for terminal in problem.terminals] or [(0, 0)]
    xs, ys = zip(*points, strict=True)
    scale = (_WIDTH - 2 * _MARGIN) / max(1, max(xs) - min(xs))
    view = _View(min(xs), max(ys), scale, chart_height + _MARGIN)
    height = chart_height + 2 * _MARGIN + scale * (max(ys) - min(ys))
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height:.0f}" '
            'font-family="sans-serif" font-size="10">',
            f'<rect width="{_WIDTH}" height="{height:.0f}" fill="white"/>',
            *_chart(problem, plan, verdict.durations),
            *_panel(problem, plan, view),
            "</svg>\n",
        )
    )


def _chart(problem: Problem, plan: Plan, ticks: tuple[int, ...]) -> Iterator[str]:
    """Draw a lane for each arm, with its actions on an axis of time."""
    starts = [action.start_ticks - problem.start_ticks for action in plan.actions]
    end = max((start + length for start, length in zip(starts, ticks, strict=True)), default=1)
    per_tick = (_WIDTH - 2 * _MARGIN) / max(1, end)
    lane = {arm.name: _MARGIN + i * _LANE for i, arm in enumerate(problem.arms)}
    for name, y in lane.items():
        yield f'<text x="8" y="{y + _LANE / 2:g}">{escape(name)}</text>'
    for action, start, length in zip(plan.actions, starts, ticks, strict=True):
        for arm in {action.arm, action.target} & set(lane):
            yield _bar(action, _MARGIN + per_tick * start, lane[str(arm)], per_tick * length)
    axis = _MARGIN + _LANE * len(lane) + _AXIS - 6
    for i in range(_LABELS_ON_AXIS + 1):
        x = _MARGIN + (_WIDTH - 2 * _MARGIN) * i / _LABELS_ON_AXIS
        seconds = end * i / _LABELS_ON_AXIS / TICKS_PER_S
        yield f'<text x="{x:.1f}" y="{axis}" text-anchor="middle">{seconds:.0f} s</text>'
    for i, (kind, fill) in enumerate(_FILLS.items()):
        x = _MARGIN + 120 * i
        yield f'<rect x="{x}" y="{axis + 8}" width="10" height="10" fill="{fill}"/>'
        yield f'<text x="{x + 14}" y="{axis + 17}">{kind.value}</text>'


def _bar(action: Action, x: float, y: float, width: float) -> str:
    what = " ".join(filter(None, (action.kind.value, action.wire, action.target)))
    return (
        f'<rect x="{x:.2f}" y="{y}" width="{width:.2f}" height="{_LANE - 8}" '
        f"fill={quoteattr(_FILLS[action.kind])}>"
        f"<title>{escape(what)} at {action.start_ticks / TICKS_PER_S:.1f} s</title></rect>"
    )


def _panel(problem: Problem, plan: Plan, view: _View) -> Iterator[str]:
    """Draw terminals and wires; a wire has its arm's colour and its number among the picks."""
    for terminal in problem.terminals:
        x, y = view.place(terminal.position_mm)
        yield (
            f'<rect x="{x - 3:.1f}" y="{y - 3:.1f}" width="6" height="6" fill="#dddddd" '
            f'stroke="#888888"><title>{escape(terminal.name)}</title></rect>'
        )
    arms = [arm.name for arm in problem.arms]
    picks = [action for action in plan.actions if action.kind is ActionKind.PICK]
    for number, action in enumerate(picks, 1):
        wire = problem.wire[str(action.wire)]
        (x1, y1), (x2, y2) = (
            view.place(problem.end_terminal(wire, end).position_mm) for end in End
        )
        stroke = _ARM_STROKES[arms.index(action.arm)]
        width = 2.5 if wire.heavy else 1
        yield (
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{stroke}" '
            f'stroke-width="{width}" stroke-opacity="0.6"><title>{number}: {escape(wire.name)} '
            f"({escape(wire.colour)}) by {escape(action.arm)}</title></line>"
        )
        yield (
            f'<text x="{(x1 + x2) / 2:.1f}" y="{(y1 + y2) / 2:.1f}" fill="{stroke}" '
            f'text-anchor="middle">{number}</text>'
        )
