"""An order before it is stored: columns of its wire list, preferences, the plan as a Gantt chart.

docs/planning.md describes the document of preferences. What an entry means is checked by the
planner alone; here it only has its fields.
"""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import yaml

from remodel_console.core.plots import LINE, TEXT, TOOLTIP
from remodel_console.errors import CommandError
from remodel_run.findings import Plan

_MAPPING_FORMAT = "remodel-wire-list-1"
NOT_USED = ""
SECTION_UNITS = ("mm2", "awg")
LENGTH_UNITS = ("mm", "cm", "m", "in", "ft")
_ENDS = {"from": "First end", "to": "Second end"}
_PARTS = {
    "": "component and terminal",
    "_component": "component",
    "_terminal": "terminal",
    "_x": "x of the component",
    "_y": "y of the component",
    "_seal": "seal",
    "_force_limit": "greatest insertion force [N]",
    "_place": "plate, door or outside",
}
_WORDS = {
    **{
        f"{end}{part}": f"{name}: {words}"
        for end, name in _ENDS.items()
        for part, words in _PARTS.items()
    },
    "wire": "Wire",
    "colour": "Colour",
    "section": "Section",
    "length": "Length",
    "cable": "Cable",
    "core": "Core of the cable",
    "twisted": "Group of twisted wires",
    "component": "One end in a line: component",
    "terminal": "One end in a line: terminal",
    "place": "One end in a line: plate, door or outside",
}


@dataclass(frozen=True)
class ListColumns:
    """The columns of a list, and what they mean as far as that is known.

    Attributes:
        rows: the first ones below the headings.
        fields: all that a column can mean.
        columns: heading of each field's column.
        units: of section, length and position.
        separator: of cells.
        terminal_separator: of the component and the terminal in a cell.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    fields: tuple[str, ...]
    columns: dict[str, str]
    units: dict[str, str]
    separator: str
    terminal_separator: str

    def meaning(self, heading: str) -> str:
        """Return the field of a column; `NOT_USED` if it has none."""
        return next((f for f, found in self.columns.items() if found == heading), NOT_USED)

    @property
    def has_ends(self) -> bool:
        """Return whether it is known where the ends of wires are."""
        known = self.columns.keys()
        return known >= {"wire", "component", "terminal"} or all(
            known & {end, f"{end}_component"} for end in _ENDS
        )

    @property
    def choices(self) -> dict[str, str]:
        """Return what a column can mean, in words, by field."""
        return {NOT_USED: "not used"} | {f: _WORDS.get(f, f) for f in self.fields}

    def mapping(
        self, meanings: Mapping[str, str], units: Mapping[str, str], terminal_separator: str
    ) -> str:
        """Return the YAML of a mapping in which columns have chosen meanings.

        Args:
            meanings: fields by heading.
            units: of section and length.
            terminal_separator: of the component and the terminal in a cell.

        Raises:
            CommandError: if two columns mean the same.
        """
        chosen = {heading: field for heading, field in meanings.items() if field != NOT_USED}
        for field, count in Counter(chosen.values()).items():
            if count > 1:
                both = " and ".join(f"'{h}'" for h, each in chosen.items() if each == field)
                raise CommandError(
                    f"{both} are both '{self.choices[field]}': choose another meaning for one"
                )
        document = {
            "format": _MAPPING_FORMAT,
            "columns": {field: heading for heading, field in chosen.items()},
            "units": {**self.units, **units},
            "separator": self.separator,
            "terminal_separator": terminal_separator or self.terminal_separator,
        }
        return yaml.safe_dump(document, sort_keys=False, allow_unicode=True)


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
    axis = {"axisTick": {"show": False}, "axisLine": LINE}
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
            "pageTextStyle": TEXT,
            "data": [each["name"] for each in series[1:]],
            "textStyle": TEXT,
            "top": 0,
        },
        "xAxis": {
            **axis,
            "type": "value",
            "min": 0,
            "max": plan.makespan_s,
            "splitLine": LINE,
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
            "axisLabel": {**TEXT, "width": 100, "overflow": "truncate"},
        },
        "dataZoom": [
            {**zoom, **look, "type": "slider", "height": 20, "bottom": 8, "labelFormatter": ""},
            {**zoom, "type": "inside", "zoomOnMouseWheel": "ctrl"},
        ],
        "tooltip": {**TOOLTIP, ":formatter": "one => one.value[4]"},
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


_PREFERENCES_FORMAT = "remodel-preferences-1"
_LONGEST = 100_000  # letters of a document
_LISTS = ("prefer", "require")
_ALL = "all"
Document = dict[str, Any]


@dataclass(frozen=True)
class EntryKind:
    """A kind of entry: the list that it stands in, its fields in their order, and what it says."""

    list_name: str
    fields: tuple[str, ...]
    meaning: str


KINDS = (
    EntryKind("prefer", ("pick", "before", "weight"), "Pick some wires before others"),
    EntryKind("prefer", ("pick", "in_order_of", "from", "weight"), "Pick wires in an order"),
    EntryKind("prefer", ("pick", "with_arm"), "Pick wires with one of the arms"),
    EntryKind("require", ("route", "before"), "Route some wires below others"),
    EntryKind("require", ("route", "in_order_of", "from"), "Route wires in an order"),
    EntryKind("require", ("arm", "x_mm"), "Limit where an arm works"),
    EntryKind("require", ("arm", "out_of"), "Keep an arm out of a zone"),
    EntryKind("require", ("avoid_segment",), "Route no wire through a segment"),
    EntryKind("require", ("insert", "force_n"), "Limit the force of insertions"),
)
WIRE_FIELDS = ("pick", "before", "route", "insert")  # that select wires
FIELD_HINTS = {
    **dict.fromkeys(WIRE_FIELDS, "all, W1, [W1, W2] or {colour: BU}"),
    "in_order_of": "such as section_mm2",
    "from": "least or greatest",
    "weight": "cost of each violation, in ticks of 0.1 s",
    "with_arm": "name of an arm",
    "arm": "name of an arm",
    "x_mm": "[least, greatest], in mm of the board",
    "out_of": "name under `zones`",
    "avoid_segment": "name of a segment of the board",
    "force_n": "the most, in N",
}


def new_document() -> Document:
    """Return a document without entries."""
    return {"format": _PREFERENCES_FORMAT}


def entries(document: Document, list_name: str) -> tuple[Mapping[str, Any], ...]:
    """Return the entries of a list."""
    return tuple(document.get(list_name) or ())


def has_entries(document: Document) -> bool:
    """Return whether a document says anything."""
    return set(document) > {"format"}


def new_entry(kind: EntryKind, name: str, texts: Mapping[str, str]) -> Document:
    """Return an entry of the texts that were filled in, each the YAML of a value.

    Raises:
        CommandError: naming the first field that is empty or no YAML.
    """
    if not name.strip():
        raise CommandError("name: give the entry a name; explanations and conflicts refer to it")
    entry: Document = {"name": name.strip()}
    for field in kind.fields:
        text = texts.get(field, "").strip()
        if not text:
            raise CommandError(f"{field}: fill it in, such as: {FIELD_HINTS[field]}")
        try:
            entry[field] = _parsed(text)
        except CommandError as error:
            raise CommandError(f"{field}: {error}; such as: {FIELD_HINTS[field]}") from error
    return entry


def chosen_wires(text: str) -> tuple[str, ...] | None:
    """Return the wires that the text of a field names; None if it is anything else, as `all`."""
    try:
        value = _parsed(text)
    except CommandError:
        return None
    if isinstance(value, str) and value != _ALL:
        return (value,)
    names = [] if value is None else value
    is_names = isinstance(names, list) and all(isinstance(each, str) for each in names)
    return tuple(names) if is_names else None  # type: ignore[arg-type]  # a list, as just checked


def with_clicked(text: str, wires: Sequence[str]) -> str:
    """Return the text of a field after a click on wires: it names all of them, or no longer any.

    Raises:
        CommandError: if the text selects wires in another way; what a person has typed is kept.
    """
    chosen = chosen_wires(text)
    if chosen is None:
        raise CommandError(f"`{text.strip()}` is no list of wires; clear the field to click wires")
    if set(wires) <= set(chosen):
        left = [name for name in chosen if name not in wires]
    else:
        left = list(dict.fromkeys((*chosen, *wires)))
    return _flow(left) if left else ""


def with_entry(document: Document, list_name: str, entry: Document) -> Document:
    """Return a document with one more entry."""
    return {**document, list_name: [*entries(document, list_name), entry]}


def without_entry(document: Document, list_name: str, entry: Mapping[str, Any]) -> Document:
    """Return a document without an entry; if another person has removed it, as it is."""
    left = list(entries(document, list_name))
    if entry in left:
        left.remove(entry)
    changed = {**document, list_name: left}
    return changed if left else {name: v for name, v in changed.items() if name != list_name}


def entry_words(entry: Mapping[str, Any]) -> str:
    """Return what an entry says besides its name."""
    fields = {name: value for name, value in entry.items() if name != "name"}
    return _flow(fields)[1:-1]


def write_document(document: Document) -> str:
    """Return the YAML of a document, an entry per line."""
    parts = []
    for key, value in document.items():
        if key in _LISTS:
            parts.append("".join((f"{key}:\n", *(f"  - {_flow(each)}\n" for each in value))))
        else:
            parts.append(yaml.safe_dump({key: value}, sort_keys=False))
    return "".join(parts)


def read_document(text: str) -> Document:
    """Return the document that a text is, as far as its form matters for editing it.

    Raises:
        CommandError: if it has no such form, with the place.
    """
    if not text.strip():
        return new_document()
    document = _parsed(text)
    if not isinstance(document, dict) or document.get("format") != _PREFERENCES_FORMAT:
        raise CommandError(f"the preferences begin with `format: {_PREFERENCES_FORMAT}`")
    for name in _LISTS:
        found = document.get(name, [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            raise CommandError(f"`{name}` holds a list of entries, such as `- {{name: ..., ...}}`")
    return document


def _flow(value: object) -> str:
    """Return the YAML of a list or a mapping, in one line."""
    text: str = yaml.safe_dump(
        value, default_flow_style=True, sort_keys=False, width=_LONGEST, allow_unicode=True
    )
    return text.rstrip("\n")


def _parsed(text: str) -> object:
    """Return the value of a YAML text; one that refers to itself is refused."""
    if len(text) > _LONGEST:
        raise CommandError(f"longer than {_LONGEST} letters")
    try:
        value = yaml.safe_load(text)  # first: it gives up on deep nesting soon
        if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, yaml.SafeLoader)):
            raise CommandError("aliases (`*name`) are not allowed; repeat the value")
        return value
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        what = getattr(error, "problem", None) or "nested too deeply or malformed"
        raise CommandError(f"{where}is no YAML: {what}") from error
