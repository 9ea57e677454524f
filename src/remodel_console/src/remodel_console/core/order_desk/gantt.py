"""A plan as a Gantt chart: what each arm does when, as options of Apache ECharts."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from remodel_run.findings import Plan

# Kinds of action as the planner names them, and what an operator reads.
ACTION_WORDS = {
    "tool": "change tool",
    "pick": "pick",
    "locate": "locate",
    "insert": "insert",
    "route": "route",
    "handover": "hand over",
    "fix": "fix",
    "extract": "extract",
}
_LANE = 34  # [pixels] height
_AROUND = 110  # [pixels] above and below the lanes: legend, axis, slider
_TASKS = "task"
_NAMED = 3  # violated preferences of a task
# A rectangle from the start to the end, with its text if there is room.
_DRAW = """(params, api) => {
  const [x, y] = api.coord([api.value(1), api.value(0)]), right = api.coord([api.value(2), 0])[0];
  const high = 0.7 * api.size([0, 1])[1], area = params.coordSys;
  const from = Math.max(x, area.x), to = Math.min(Math.max(right, x + 1), area.x + area.width);
  if (to <= from) return null;
  const shape = { x: from, y: y - high / 2, width: to - from, height: high };
  const children = [{ type: 'rect', shape, style: { fill: api.visual('color'), stroke: 'var(--sheet)', lineWidth: 0.5 } }];
  const text = String(api.value(3));
  if (to - from > 9 * text.length + 4) children.push({ type: 'text', style:
    { text, x: from + 4, y, fill: 'var(--ink)', verticalAlign: 'middle', fontSize: 12 } });
  return { type: 'group', children };
}"""  # noqa: E501 - JavaScript


@dataclass(frozen=True)
class TaskTime:
    """When an arm has a task in its hands, from its first action to the end of its last [s].

    Attributes:
        task: a wire, or a cable.
        wires: the wire, or the cores of the cable in their order.
    """

    task: str
    wires: tuple[str, ...]
    arm: str
    start_s: float
    end_s: float

    @property
    def words(self) -> str:
        """Return the task, and the cores of a cable."""
        is_wire = self.wires == (self.task,)
        return self.task if is_wire else f"{self.task}: {', '.join(self.wires)}"


def task_times(plan: Plan) -> tuple[TaskTime, ...]:
    """Return when each arm works on each task, in the order in which they begin."""
    cable_of = {wire: cable for cable, wires in plan.cables.items() for wire in wires}
    found: list[TaskTime] = []
    for arm in plan.arms:
        own = [each for each in _wire_times(plan) if each.arm == arm]
        for cable, group in groupby(own, lambda each: cable_of.get(each.task, "")):
            times = list(group)
            if not cable:
                found += times
                continue
            wires = tuple(each.task for each in times)
            found.append(TaskTime(cable, wires, arm, times[0].start_s, times[-1].end_s))
    return tuple(sorted(found, key=lambda each: each.start_s))


def _wire_times(plan: Plan) -> tuple[TaskTime, ...]:
    """Return when each arm works on each wire, in the order in which they begin."""
    found: dict[tuple[str, str], TaskTime] = {}
    for action in plan.actions:
        if not action.wire:
            continue
        end_s = action.start_s + action.duration_s
        known = found.get((action.wire, action.arm))
        start_s = known.start_s if known else action.start_s
        wire, arm = action.wire, action.arm
        found[wire, arm] = TaskTime(wire, (wire,), arm, start_s, end_s)
    return tuple(sorted(found.values(), key=lambda each: each.start_s))


def violated_words(plan: Plan, wires: Iterable[str]) -> str:
    """Return what a plan violates of preferences about some wires, the first three of them."""
    found = tuple(dict.fromkeys(words for wire in wires for words in plan.violated.get(wire, ())))
    more = (f"and {len(found) - _NAMED} more",) if len(found) > _NAMED else ()
    return "; ".join((*found[:_NAMED], *more))


def gantt_plot(plan: Plan) -> dict[str, Any]:
    """Return two lanes for each arm: its tasks, and their actions."""
    lanes = [name for arm in plan.arms for name in (f"{arm} {_TASKS}s", arm)]
    lane = {name: place for place, name in enumerate(lanes)}
    series = [_series(_TASKS, list(_task_bars(plan, lane)))]
    for kind, words in ACTION_WORDS.items():
        bars = [
            _bar(
                lane[each.arm],
                each.start_s,
                each.duration_s,
                "",
                " ".join(filter(None, (words, each.wire, each.target))),
            )
            for each in plan.actions
            if each.action == kind
        ]
        if bars:
            series.append(_series(words, bars, kind))
    text = {"color": "var(--ink)", "fontSize": 12}
    line = {"lineStyle": {"color": "var(--line)"}}
    axis = {"axisTick": {"show": False}, "axisLine": line}
    zoom = {"xAxisIndex": 0, "filterMode": "weakFilter"}
    look = {
        "borderColor": "var(--line)",
        "fillerColor": "rgba(120, 140, 160, .25)",
        "textStyle": {"color": "var(--soft)"},
        "dataBackground": {"lineStyle": {"opacity": 0}, "areaStyle": {"opacity": 0}},
        "selectedDataBackground": {"lineStyle": {"opacity": 0}, "areaStyle": {"opacity": 0}},
    }
    return {
        "animation": False,
        "grid": {"left": 116, "right": 16, "top": 34, "bottom": 66},
        "legend": {
            "type": "scroll",
            "pageTextStyle": text,
            "data": [each["name"] for each in series[1:]],
            "textStyle": text,
            "top": 0,
        },
        "xAxis": {
            **axis,
            "type": "value",
            "min": 0,
            "max": plan.makespan_s,
            "splitLine": line,
            "axisLabel": {
                "color": "var(--soft)",
                ":formatter": "value => `${Math.round(value)} s`",
            },
        },
        "yAxis": {
            **axis,
            "type": "category",
            "inverse": True,
            "data": lanes,
            "axisLabel": {**text, "width": 100, "overflow": "truncate"},
        },
        "dataZoom": [
            {**zoom, **look, "type": "slider", "height": 20, "bottom": 8, "labelFormatter": ""},
            {**zoom, "type": "inside", "zoomOnMouseWheel": "ctrl"},
        ],
        "tooltip": {
            "confine": True,
            "backgroundColor": "var(--sheet)",
            "borderColor": "var(--line)",
            "textStyle": text,
            ":formatter": "one => one.value[4]",
        },
        "series": series,
    }


def gantt_height(plan: Plan) -> int:
    """Return the height of a `gantt_plot` [pixels]."""
    return _AROUND + 2 * _LANE * len(plan.arms)


def _task_bars(plan: Plan, lane: dict[str, int]) -> Iterator[list[object]]:
    for each in task_times(plan):
        place = lane[f"{each.arm} {_TASKS}s"]
        violated = violated_words(plan, each.wires)
        label = f"⚠ {each.task}" if violated else each.task
        words = f"{each.words} ({violated})" if violated else each.words
        yield _bar(place, each.start_s, each.end_s - each.start_s, label, words)


def _bar(lane: int, start_s: float, duration_s: float, label: str, words: str) -> list[object]:
    """Return lane, start, end [s], label, and the tooltip, which the browser takes as HTML."""
    end_s = start_s + duration_s
    tip = html.escape(f"{words}: {start_s:.1f} to {end_s:.1f} s")
    return [lane, round(start_s, 1), round(end_s, 1), label, tip]


def _series(name: str, bars: list[list[object]], kind: str = "tasks") -> dict[str, Any]:
    return {
        "type": "custom",
        "name": name,
        ":renderItem": _DRAW,
        "encode": {"x": [1, 2], "y": 0},
        "itemStyle": {"color": f"var(--plan-{kind})"},
        "emphasis": {"disabled": True},
        "data": bars,
    }
