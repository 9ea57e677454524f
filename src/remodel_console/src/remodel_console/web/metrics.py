"""Figures for Prometheus: what runs, what waits, and the sums of the order under way."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4
from prometheus_client.registry import Collector
from starlette.responses import Response

from remodel_console.core.inbox import cards
from remodel_console.core.run import run_view
from remodel_console.core.use_case.use_case import UseCase
from remodel_console.core.world import Part, World
from remodel_run.progress import Count, Phase


class _Figures(Collector):
    """A collector of what is there at the moment of each request."""

    def __init__(self, world: Callable[[], World]) -> None:
        self._world = world

    def collect(self) -> Iterator[GaugeMetricFamily]:
        """Yield all figures."""
        world = self._world()
        runs = GaugeMetricFamily("remodel_up", "1 if it runs and answers", labels=["part"])
        for part in Part:
            runs.add_metric([part.name.lower()], world.has(part))
        yield runs
        yield GaugeMetricFamily("remodel_abilities", "Ability servers that answer", world.servers)
        waiting = len(cards(world))
        yield GaugeMetricFamily("remodel_waiting", "What waits for a person", waiting)
        is_running = world.run.phase is run_view.Phase.RUNNING
        yield GaugeMetricFamily("remodel_behavior_running", "1 while a behavior runs", is_running)
        now = world.current_use_case
        if now is not None and now.run:
            yield from _of_run(now)


def _of_run(now: UseCase) -> Iterator[GaugeMetricFamily]:
    """Yield the figures of a run, or of the last one."""
    names, values = ["order", "serial", "cell"], [now.order, now.serial, now.cell]
    phase = GaugeMetricFamily("remodel_run_phase", "1 for the phase", labels=[*names, "phase"])
    for each in Phase:
        phase.add_metric([*values, each.value], each is now.phase)
    yield phase
    tasks = GaugeMetricFamily("remodel_tasks", "Tasks of the run", labels=[*names, "count"])
    for count in Count:
        tasks.add_metric([*values, count.value], getattr(now.sums, count.value))
    yield tasks
    sums = now.sums
    for name, words, value in (
        ("remodel_wires_by_hand", "Wires that a person places", sums.by_hand),
        ("remodel_tasks_tried", "Tasks that have ended in this run", sums.tried),
        ("remodel_first_passes", "Tasks that were done at the first attempt", sums.first_passes),
        ("remodel_recovered", "Tasks that were done after a failure", sums.recovered),
        ("remodel_done_seconds", "Time of the tasks that are done [s]", sums.done_s),
        ("remodel_left_seconds", "Time that is still expected [s]", now.left_s),
    ):
        family = GaugeMetricFamily(name, words, labels=names)
        family.add_metric(values, value)
        yield family


def metrics_of(world: World) -> Response:
    """Return the figures in the text form that Prometheus reads."""
    registry = CollectorRegistry()
    registry.register(_Figures(lambda: world))
    return Response(generate_latest(registry), media_type=CONTENT_TYPE_PLAIN_0_0_4)
