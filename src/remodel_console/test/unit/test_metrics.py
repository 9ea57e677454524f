"""What Prometheus reads of the console, and the dashboard that shows it; no ROS."""

import json
import re
from pathlib import Path

from remodel_console.core.use_case import UseCase
from remodel_console.core.world import World
from remodel_console.web.server import metrics_of
from remodel_run.progress import Phase, Sums

DASHBOARD = Path(__file__).parents[2] / "config" / "grafana.json"
RUN = UseCase(
    Phase.RUNNING,
    cell="cell 1",
    run=7,
    order='house "2"',
    serial="h-1",
    sums=Sums(tasks=5, done=2, skipped=1, open=2, tried=3, first_passes=1, recovered=1),
)


def read(world):
    return metrics_of(world).body.decode()


def test_without_a_run_there_is_what_runs():
    text = read(World(has_master=True, servers=13))
    assert 'remodel_up{part="cell"} 1.0' in text
    assert 'remodel_up{part="engine"} 0.0' in text
    assert "remodel_abilities 13.0" in text
    assert "remodel_tasks" not in text


def test_the_sums_of_the_run_are_those_of_the_pages():
    text = read(World(has_master=True, has_supervisor=True, use_case=RUN))
    labels = r'{cell="cell 1",%sorder="house \"2\"",%sserial="h-1"}'
    assert "remodel_tasks" + labels % ('count="done",', "") + " 2.0" in text
    assert "remodel_tasks" + labels % ('count="skipped",', "") + " 1.0" in text
    assert "remodel_run_phase" + labels % ("", 'phase="running",') + " 1.0" in text
    assert "remodel_first_passes" + labels % ("", "") + " 1.0" in text
    assert "remodel_tasks" not in read(World(use_case=RUN, outdated_s=1.0)), "out of date"


def test_the_dashboard_shows_figures_that_there_are():
    known = set(re.findall(r"^(remodel_\w+)", read(World(use_case=RUN)), re.MULTILINE))
    panels = json.loads(DASHBOARD.read_text())["panels"]
    used = [target["expr"] for panel in panels for target in panel["targets"]]
    assert used
    for expr in used:
        assert set(re.findall(r"remodel_\w+", expr)) <= known, expr
