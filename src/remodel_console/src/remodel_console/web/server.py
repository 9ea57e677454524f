"""Serve the pages, and figures for Prometheus."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

from nicegui import app, core, ui
from nicegui import run as on_thread
from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4
from prometheus_client.registry import Collector
from starlette.requests import Request
from starlette.responses import FileResponse, RedirectResponse, Response

from remodel_console.console import Console
from remodel_console.core import run_view
from remodel_console.core.use_case import UseCase
from remodel_console.core.world import Part, World, cards
from remodel_console.edge.kept_files import stl_of
from remodel_console.edge.users_file import UsersFile
from remodel_console.errors import CommandError
from remodel_console.web.configuration_page import ConfigurationPage
from remodel_console.web.editing_page import SESSION, released
from remodel_console.web.editor_page import EditorPage
from remodel_console.web.guard import Guard
from remodel_console.web.order_desk_page import ADDRESS, FILE_ADDRESS, OrderDeskPage, take_design
from remodel_console.web.overview_page import OverviewPage, StatisticsPage
from remodel_console.web.page import Broadcast
from remodel_console.web.replay_page import ReplayPage
from remodel_console.web.runtime_page import RuntimePage
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


_STATIC = Path(__file__).parent / "static"
_HEAD = (
    '<link rel="stylesheet" href="/console/console.css">'
    '<script src="/console/connection.js"></script>'
    '<script src="/console/menus.js"></script>'
    '<script src="/console/splitters.js"></script>'
)
_PNG = b"\x89PNG"  # how such a file begins
# A drawing has names out of a file; whatever they are, it runs no script.
_PICTURE_ONLY = {
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'",
    "Cache-Control": "no-store",
}
_RECONNECT_S = 30.0  # for which the page of a browser that has lost us is kept
# A page without pings says so after 5 s. Its connection is kept longer, since what was pressed
# while we were stalled would be lost with it, but not so long that a late command surprises.
_PING_S, _PONG_S = 2.0, 10.0


def serve(console: Console, port: int, users: UsersFile | None = None) -> None:
    """Serve until a signal ends the process."""
    broadcast = Broadcast()
    app.add_static_files("/console", _STATIC)
    app.add_middleware(Guard, door=console.door, users=users, record=console.desk.record)
    app.on_startup(broadcast.bind)
    app.on_startup(_ping_often)
    console.live.on_change(broadcast.wake)
    console.pictures.on_change(broadcast.wake)
    console.sessions.on_change(broadcast.wake)
    console.settings.on_change = broadcast.wake
    console.drafts.on_change = broadcast.wake
    ui.add_head_html(_HEAD, shared=True)

    @ui.page("/")
    def front() -> Response:
        return RedirectResponse("/overview")

    @app.get("/picture/{camera}")
    def picture(camera: str) -> Response:
        found = console.pictures.newest(camera)
        if found is None:
            return Response("no picture of this camera", 404)
        return Response(found.jpeg, media_type="image/jpeg", headers={"Cache-Control": "no-store"})

    @app.get("/log.txt")
    async def log() -> Response:
        text = await on_thread.io_bound(console.live.exported_log)
        headers = {"Content-Disposition": "attachment; filename=remodel-log.txt"}
        return Response(text, media_type="text/plain; charset=utf-8", headers=headers)

    @app.get("/metrics")
    def metrics() -> Response:
        return metrics_of(console.live.world)

    @app.get("/mesh/{number}")
    async def mesh(number: int) -> Response:
        file = console.meshes.file(number)
        if file is None:
            return Response("no robot has such a mesh", 404)
        try:
            return Response(await on_thread.io_bound(stl_of, file), media_type="model/stl")
        except (OSError, ValueError) as error:
            return Response(str(error), 404)

    @app.get("/record/{run}/{position}")
    async def recorded(run: int, position: int) -> Response:
        return await _recorded(console, run, position)

    @app.post(FILE_ADDRESS)
    async def design(request: Request) -> Response:
        return await take_design(console.drafts, request)

    @app.get(ADDRESS + "/board/{key}")
    def board(key: str) -> Response:
        draft = console.drafts.get(key)
        if draft is None or not draft.now.boards:
            return Response("this order has no board", 404)
        return FileResponse(draft.board, media_type="image/svg+xml", headers=_PICTURE_ONLY)

    @app.get(ADDRESS + "/rehearsal/{key}/{name}")
    def picture_of_rehearsal(key: str, name: str) -> Response:
        draft = console.drafts.get(key)
        if draft is None or not draft.picture(name).is_file():
            return Response("there is no such picture", 404)
        return FileResponse(draft.picture(name), media_type="image/png", headers=_PICTURE_ONLY)

    @ui.page(ADDRESS)
    def order_desk(request: Request) -> None:
        OrderDeskPage(console, broadcast, request, "Order desk")

    @ui.page("/replay")
    def replay(request: Request) -> None:
        ReplayPage(console, broadcast, request, "Replay")

    @ui.page("/overview")
    def overview(request: Request) -> None:
        OverviewPage(console, broadcast, request, "Overview")

    @ui.page("/statistics")
    def statistics(request: Request) -> None:
        StatisticsPage(console, broadcast, request, "Statistics")

    @ui.page("/runtime")
    def runtime(request: Request) -> None:
        RuntimePage(console, broadcast, request, "Runtime control")

    @ui.page("/editor")
    async def editor(request: Request) -> None:
        await released(console.sessions, request.query_params.get(SESSION, ""))
        await on_thread.io_bound(console.list_names)  # which the page offers from its first paint
        EditorPage(console, broadcast, request, "Editor")

    @ui.page("/configuration")
    def configuration(request: Request) -> None:
        ConfigurationPage(console, broadcast, request, "Configuration")

    with contextlib.suppress(KeyboardInterrupt):  # how a signal ends the server
        ui.run(
            host=console.door.host,
            port=port,
            title="REMODEL",
            language="en-US",
            favicon=_STATIC / "icon.svg",
            reconnect_timeout=_RECONNECT_S,
            show=False,
            reload=False,
            show_welcome_message=False,
        )


def _ping_often() -> None:
    """Check more often than NiceGUI's default whether pages are still open."""
    core.sio.eio.ping_interval, core.sio.eio.ping_timeout = _PING_S, _PONG_S


async def _recorded(console: Console, run: int, position: int) -> Response:
    """Return the picture of an entry in a run's record."""
    if console.recorder is None:
        return Response("ROS is not running", 503)
    try:
        picture = await on_thread.io_bound(console.recorder.picture, run, position)
    except CommandError as error:
        return Response(str(error), 404)
    kind = "image/png" if picture.startswith(_PNG) else "image/jpeg"
    return Response(picture, media_type=kind)
