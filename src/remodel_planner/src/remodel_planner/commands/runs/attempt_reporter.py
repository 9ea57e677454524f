"""Report attempts: draw the charts with the path taken, and choose the pictures."""

from __future__ import annotations

from pathlib import Path

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.export.draw import chart_to_dot
from flexbe_synthesizer.edge.files import dot_picture
from remodel_planner.core.reports.run_report import AttemptReport, Drawing, Picture, attempt_result
from remodel_production.core.production import Wire
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.attempts import Attempt
from remodel_supervision.core.runs.entries import seen_by
from remodel_supervision.core.runs.replay import Trace, trace
from remodel_supervision.edge.known_behaviors import nested_charts
from remodel_tasks.edge.fault_file import read_error_names


class AttemptReporter:
    """Makes the reports of attempts at tasks."""

    def __init__(self, pictures: Path) -> None:
        """Take the folder of the run's pictures; those that are not there are left out."""
        self._pictures = pictures
        self._nested = nested_charts()
        self._error_names = read_error_names()

    def report(self, attempt: Attempt, wire: Wire | None, length_m: float) -> AttemptReport:
        """Return the report of one attempt."""
        operations = attempt.execution.operations
        chart = parse_chart(attempt.chart, "record")
        taken = trace(chart, operations, self._nested, self._error_names)
        return AttemptReport(
            wire,
            length_m,
            attempt.execution,
            attempt_result(attempt),
            tuple(_drawings(taken)),
            pictures=tuple(self._picture(name, operations) for name in self._there(attempt)),
        )

    def overview(self, attempt: Attempt) -> tuple[Picture, ...]:
        """Return the picture of the whole cell after an attempt."""
        last = [name for name in self._there(attempt) if name.endswith("_scene.jpg")]
        return tuple(self._read("The cell at the end", name) for name in last)

    def _there(self, attempt: Attempt) -> list[str]:
        return [name for name in attempt.pictures if (self._pictures / name).is_file()]

    def _picture(self, name: str, operations: tuple[Operation, ...]) -> Picture:
        camera, stamp_s = seen_by(name)
        if camera == "scene":
            return self._read("The panel afterwards", name)
        return self._read(_caption(stamp_s, camera, operations), name)

    def _read(self, caption: str, name: str) -> Picture:
        return Picture.of_jpeg(caption, (self._pictures / name).read_bytes())


def _drawings(taken: Trace) -> list[Drawing]:
    caption = f"{taken.chart.name} {taken.path}".strip()
    svg = dot_picture(chart_to_dot(taken.chart, taken.steps), ".svg").decode()
    drawings = [Drawing(caption, svg[svg.index("<svg") :])]
    for child in taken.children:
        drawings += _drawings(child)
    return drawings


def _caption(stamp_s: float, camera: str, operations: tuple[Operation, ...]) -> str:
    """Return which ability made a picture, by the time at which it was made."""
    for operation in operations:
        if operation.ended_s - operation.elapsed_s <= stamp_s <= operation.ended_s:
            return f"{operation.state_path.lstrip('/')}: {camera} camera"
    return f"{camera} camera"
