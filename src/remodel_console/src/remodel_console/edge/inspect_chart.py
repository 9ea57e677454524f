"""Check a text that is being edited."""

from __future__ import annotations

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.problem import errors_in
from remodel_console.core.editor.inspection import Inspection, uses_by_path
from remodel_console.edge.workspace import Workspace
from remodel_console.errors import CommandError


def inspect_text(workspace: Workspace, text: str, file: str) -> tuple[Chart | None, Inspection]:
    """Return the chart that a text has the form of, if it has, and what the checks say about it."""
    chart, problems = workspace.memory.read(text.encode("utf-8", "surrogatepass"), file)
    is_formed = chart is not None and not errors_in(problems)
    try:
        files = workspace.look(text, file)
    except CommandError as error:
        return (chart if is_formed else None), Inspection(problems, unchecked=str(error))
    own = files.charts.get(file)
    uses = uses_by_path(own.resolved) if own else {}
    order = sorted(files.problems, key=lambda problem: problem.position.file != file)
    package = files.packages[file].name if own else ""
    found = Inspection(tuple(order), uses, checked=own, package=package)
    return (chart if is_formed else None), found
