"""The report of a run: values in, HTML and plain data out.

The page stands alone (pictures and drawings are in it), so that it can be mailed or archived.
"""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field

from jinja2 import Environment, StrictUndefined

from remodel_planner.core.net_list import Connection, Verdict, share_in_ducts
from remodel_production.core.production import Order, Wire
from remodel_run.progress import Sums, sums_words
from remodel_run.rehearsal import Forecast, Share
from remodel_run.whole_task import WholeTask, counted
from remodel_states.core.wires import hex_colours
from remodel_supervision.core.run import Execution, Operation
from remodel_supervision.core.runs.attempts import Attempt
from remodel_supervision.core.runs.events import Part

INSERTION = "InsertCable"

# What becomes of an attempt that does what it is for.
PLACED, DISCARDED, EMPTIED = "placed", "discarded", "hand emptied"

# Of an ability without a colour of its own.
_OTHER_COLOUR = "#adb5bd"


@dataclass(frozen=True)
class Picture:
    """A camera picture as a data URI, with what it shows."""

    caption: str
    uri: str

    @classmethod
    def of_jpeg(cls, caption: str, jpeg: bytes) -> Picture:
        """Return a picture from the content of a JPEG file."""
        return cls(caption, f"data:image/jpeg;base64,{base64.b64encode(jpeg).decode()}")


@dataclass(frozen=True)
class Drawing:
    """A drawn chart (SVG text) with the path taken, and its name."""

    caption: str
    svg: str


@dataclass(frozen=True)
class AttemptReport:
    """What the report contains about one attempt at a task.

    Attributes:
        wire: that the task places; None for a task of another kind, such as a branch of a harness.
        length_m: [m] of the wire.
        result: of the attempt, for a person.
    """

    wire: Wire | None
    length_m: float
    execution: Execution
    result: str
    drawings: tuple[Drawing, ...]
    pictures: tuple[Picture, ...]

    @property
    def good(self) -> bool:
        """Whether it did what it was for."""
        return self.result in (PLACED, DISCARDED, EMPTIED)

    @property
    def label(self) -> str:
        """The task's name, and the attempt if it is not the first."""
        name, number = self.execution.wire, self.execution.attempt
        return name if number == 1 else f"{name}, attempt {number}"

    @property
    def anchor(self) -> str:
        """What the page's links lead to."""
        return f"{self.execution.wire}-{self.execution.attempt}"


@dataclass(frozen=True)
class Predicted:
    """What a rehearsal said of a wire, and what happened to it.

    Attributes:
        at_once: probability of the first attempt.
        happened: for a person.
        was_at_once: whether the first attempt succeeded.
    """

    wire: str
    at_once: Share
    happened: str
    was_at_once: bool


@dataclass(frozen=True)
class Report:
    """What the report contains about a run.

    Attributes:
        wall_s: [s] wall time from the beginning of the run to its end.
        overview: pictures of the whole cell.
        stopped: why the run ended before its time; empty if it did not.
        before: names of the wires that earlier runs, or other cells, have placed.
        triage: a line for each wire by hand, and for wires that are done by another method.
        sums: of the run's tasks, as all views show them.
        nets: what the design connects, beside what a simulated cell says that it has.
        unread: why the cell did not say what was built; empty if it did.
        simulated_s: [s] ROS time of the run; None if that is wall time.
        finished: pictures of what was built, at the end.
        forecast: of the order's newest rehearsal; None: it was not rehearsed.
    """

    order: Order
    tasks: tuple[WholeTask, ...]
    wall_s: float
    attempts: tuple[AttemptReport, ...]
    overview: tuple[Picture, ...]
    stopped: str = ""
    before: frozenset[str] = frozenset()
    triage: tuple[str, ...] = ()
    sums: Sums = field(default_factory=Sums)
    nets: tuple[Connection, ...] = ()
    unread: str = ""
    simulated_s: float | None = None
    finished: tuple[Picture, ...] = ()
    forecast: Forecast | None = None

    @property
    def predicted(self) -> tuple[Predicted, ...]:
        """What the rehearsal said of the wires that were tried, and what happened to them."""
        if self.forecast is None:
            return ()
        failed = {a.execution.wire for a in self.attempts if a.execution.failures}
        tried = {attempt.execution.wire for attempt in self.attempts}
        found = []
        for wire in (each for each in self.forecast.wires if each.wire in tried):
            is_placed = wire.wire in self.placed_wires
            was_at_once = is_placed and wire.wire not in failed
            happened = "at the first attempt" if was_at_once else "after a failure"
            happened = happened if is_placed else "not placed"
            found.append(Predicted(wire.wire, wire.at_once, happened, was_at_once))
        return tuple(found)

    @property
    def brier_score(self) -> float | None:
        """Mean squared difference between these probabilities and what happened; None without."""
        found = self.predicted
        if not found:
            return None
        return sum((each.at_once.mean - each.was_at_once) ** 2 for each in found) / len(found)

    @property
    def planned(self) -> int:
        """The number of wires that were to be placed, cores of cables among them."""
        return sum(len(task.wires) for task in self.tasks)

    @property
    def has_cables(self) -> bool:
        """Whether tasks and wires are counted apart."""
        return any(task.is_cable for task in self.tasks)

    @property
    def placed_wires(self) -> frozenset[str]:
        """The names of the wires placed; this run's by the cell's ground truth, if it has one."""
        here = (each.execution.wire for each in self.attempts if each.execution.placed)
        return self.before.union(here)

    @property
    def placed(self) -> int:
        """The number of wires placed."""
        return len(self.placed_wires)

    @property
    def cables(self) -> dict[str, str]:
        """A line for each cable of which cores were tried, by the name of the first of them."""
        lines: dict[str, str] = {}
        tried = dict.fromkeys(attempt.execution.wire for attempt in self.attempts)
        for task in self.tasks:
            first = next((wire for wire in tried if wire in task.wires), None)
            if task.is_cable and first is not None:
                done = len(self.placed_wires.intersection(task.wires))
                lines[first] = f"Cable {task.name}: {done} of {len(task.wires)} cores placed"
        return lines

    @property
    def insertions(self) -> tuple[int, int]:
        """How many ends the first insertion seated, and how many ends were inserted at all."""
        seated: dict[tuple[str, str, str], bool] = {}
        for attempt in self.attempts:
            for operation in attempt.execution.operations:
                if operation.ability == INSERTION:
                    given = dict(operation.parameters)
                    terminal = (given.get("component_id", ""), given.get("terminal_id", ""))
                    end = (attempt.execution.wire, *terminal)
                    seated.setdefault(end, operation.error_code == 0)
        return sum(seated.values()), len(seated)

    @property
    def differences(self) -> tuple[Connection, ...]:
        """The wires that are not as designed, wrong ones first."""
        return tuple(
            net
            for verdict in (Verdict.WRONG, Verdict.MISSING)
            for net in self.nets
            if net.verdict is verdict
        )

    @property
    def in_ducts(self) -> float | None:
        """At which share of their routes in ducts the wires lie below the rims."""
        return share_in_ducts(self.nets)

    @property
    def real_time_factor(self) -> float | None:
        """How much faster than the wall clock the cell's time passed."""
        if self.simulated_s is None or not self.wall_s:
            return None
        return self.simulated_s / self.wall_s

    @property
    def failures(self) -> int:
        """The number of operations that failed, recovered from or not."""
        return sum(len(attempt.execution.failures) for attempt in self.attempts)

    @property
    def complete(self) -> bool:
        """Whether every planned wire is placed."""
        return self.placed == self.planned


@dataclass(frozen=True)
class Bar:
    """An operation in the timeline; x and width in percent of its row."""

    x: float
    width: float
    colour: str
    failed: bool
    title: str


def timeline(
    attempts: tuple[AttemptReport, ...], colours: Mapping[str, str]
) -> dict[str, tuple[Bar, ...]]:
    """Return for each attempt's label its operations as bars over the longest one's duration."""
    longest = max((attempt.execution.cell_s for attempt in attempts), default=0.0)
    scale = 100 / longest if longest else 0.0
    rows = {}
    for attempt in attempts:
        start = attempt.execution.started_s
        rows[attempt.label] = tuple(
            Bar(
                round((operation.ended_s - operation.elapsed_s - start) * scale, 3),
                round(max(operation.elapsed_s * scale, 0.2), 3),
                colours.get(operation.ability, _OTHER_COLOUR),
                operation.has_failed,
                title=f"{operation.ability}: {operation.outcome or 'left'}, "
                f"{operation.elapsed_s:.1f} s",
            )
            for operation in attempt.execution.operations
        )
    return rows


def render_html(template: str, report: Report, colours: Mapping[str, str]) -> str:
    """Return the page by the text of templates/report.html.j2; colours are by ability."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    return environment.from_string(template).render(
        report=report,
        bars=timeline(report.attempts, colours),
        ability_colours=colours,
        background=_background,
    )


def _background(colour: str) -> str:
    """Return what a swatch of a wire's colour is filled with: its colours, one beside another."""
    colours = hex_colours(colour)
    share = 100 // len(colours)
    stops = (f"{rgb} {i * share}% {(i + 1) * share}%" for i, rgb in enumerate(colours))
    return f"linear-gradient(90deg, {', '.join(stops)})" if len(colours) > 1 else colours[0]


def report_data(report: Report) -> Mapping[str, object]:
    """Return the report as plain data for JSON, without pictures and drawings."""
    return {
        "order": report.order.name,
        "source": report.order.source,
        "tasks": [{"name": task.name, "wires": list(task.wires)} for task in report.tasks],
        "tasks_done": report.sums.done_in_all,
        "sums": asdict(report.sums),
        "planned": report.planned,
        "placed": report.placed,
        "first_pass": report.sums.first_passes,
        "failures": report.failures,
        "complete": report.complete,
        "stopped": report.stopped,
        "recovered": report.sums.recovered,
        "insertions": dict(zip(("seated_at_once", "ends"), report.insertions, strict=True)),
        "wall_s": round(report.wall_s, 1),
        "simulated_s": _rounded(report.simulated_s, 1),
        "real_time_factor": _rounded(report.real_time_factor, 2),
        "cell_s": round(report.sums.taken_s, 1),
        "cables": list(report.cables.values()),
        "wires": [_attempt_data(attempt) for attempt in report.attempts],
        "triage": list(report.triage),
        "unread": report.unread,
        "net_list": [_net_data(net) for net in report.nets],
        "in_ducts": _rounded(report.in_ducts, 4),
        "predicted": [
            {"wire": each.wire, "at_once": each.at_once.mean, "was_at_once": each.was_at_once}
            for each in report.predicted
        ],
        "brier_score": _rounded(report.brier_score, 4),
        "notes": list(report.order.notes),
    }


def _net_data(net: Connection) -> Mapping[str, object]:
    found = net.found
    ends = (found.a, found.b) if found is not None else ()
    return {
        "wire": net.wire,
        "design": [str(ref) for ref in net.designed],
        "cell": [str(end.at or "") for end in ends],
        "fixed": [end.is_fixed for end in ends],
        "verdict": net.verdict.value,
        "difference": net.difference,
        "duct_length_m": _rounded(found.duct_length_m if found else None, 3),
        "in_ducts": _rounded(found.in_ducts if found and found.duct_length_m else None, 4),
    }


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)


def _attempt_data(attempt: AttemptReport) -> Mapping[str, object]:
    execution, wire = attempt.execution, attempt.wire
    return {
        "wire": execution.wire,
        **(_wire_data(wire, attempt.length_m) if wire is not None else {}),
        "behavior": execution.behavior,
        "attempt": execution.attempt,
        "outcome": execution.outcome,
        "placed": execution.placed,
        "insertions": execution.tries(INSERTION),
        "failures": [failure_line(operation) for operation in execution.failures],
        "cell_s": round(execution.cell_s, 2),
        "operations": [asdict(operation) for operation in execution.operations],
    }


def _wire_data(wire: Wire, length_m: float) -> Mapping[str, object]:
    return {
        "a": str(wire.a),
        "b": str(wire.b),
        "colour": wire.colour,
        "section_mm2": wire.section_mm2,
        "cable": wire.cable,
        "length_m": length_m,
        "number": wire.number,
        "source": wire.source,
    }


def attempt_result(attempt: Attempt) -> str:
    """Return what became of an attempt, for a person."""
    execution = attempt.execution
    finished = execution.outcome == "finished"
    if attempt.part is Part.CLEAR:
        return EMPTIED
    if attempt.part is Part.DISCARD:
        return DISCARDED if finished else "NOT discarded"
    if attempt.because:
        return f"interrupted ({attempt.because})"
    if execution.placed:
        return PLACED if finished else f"NOT placed ({execution.outcome}, both ends fixed)"
    if finished:
        return "finished, not confirmed by the cell's ground truth"
    return f"NOT placed ({execution.outcome})"


def failure_line(operation: Operation) -> str:
    """Return what failed and why, in one line."""
    return f"{operation.ability}, error {operation.error_code}: {operation.text}"


# Differences from the design that are listed; the report has all of them.
_LISTED = 8


def summary_lines(report: Report) -> Iterator[str]:
    """Yield the lines."""
    before = f" ({len(report.before)} of them before)" if report.before else ""
    if report.has_cables or report.sums.done_in_all < report.sums.tasks:
        yield sums_words(report.sums)
    yield (
        f"{report.placed} of {counted(report.planned, 'wire')} placed{before}, "
        f"{report.sums.first_passes} without a failed operation; "
        f"{counted(report.failures, 'failed operation')}; "
        f"{report.sums.taken_s:.0f} s in the cell, {report.wall_s:.0f} s on the clock"
    )
    seated, ends = report.insertions
    if ends:
        yield (
            f"{seated} of {counted(ends, 'end')} seated by the first insertion; "
            f"{counted(report.sums.recovered, 'wire')} recovered"
        )
    if report.real_time_factor is not None:
        yield (
            f"{report.simulated_s:.0f} s simulated in {report.wall_s:.0f} s, "
            f"real-time factor {report.real_time_factor:.2f}"
        )
    yield from _built_lines(report)
    if report.sums.by_hand:
        yield f"by hand: {counted(report.sums.by_hand, 'wire')}, listed in the report"


def _built_lines(report: Report) -> Iterator[str]:
    if report.unread:
        yield f"net list: not read back: {report.unread}"
        return
    if not report.nets:
        return
    counts = Counter(net.verdict for net in report.nets)
    others = "".join(
        f", {counts[verdict]} {verdict.value}"
        for verdict in (Verdict.WRONG, Verdict.MISSING)
        if counts[verdict]
    )
    right = counts[Verdict.AS_DESIGNED]
    yield f"net list: {right} of {counted(len(report.nets), 'wire')} as designed{others}"
    differences = report.differences
    for net in differences[:_LISTED]:
        designed = " to ".join(map(str, net.designed))
        yield f"  {net.wire} {net.verdict.value}: designed {designed}, {net.difference}"
    if len(differences) > _LISTED:
        yield f"  and {len(differences) - _LISTED} more"
    if report.in_ducts is not None:
        yield f"routes: below the rims at {report.in_ducts:.1%} of their length in ducts"
