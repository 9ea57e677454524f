"""The charts of the behaviors that tasks nest: those that remodel_behaviors ships."""

from __future__ import annotations

from collections.abc import Mapping

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_supervision.edge.package_files import behavior_charts


def nested_charts() -> Mapping[str, Chart]:
    """Return the charts, by name."""
    path = behavior_charts() / "place_connector.xml"
    chart = parse_chart(path.read_text(encoding="utf-8"), str(path))
    return {chart.name: chart}
