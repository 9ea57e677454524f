"""The cell on a page, in three dimensions and in pictures."""

from __future__ import annotations

import time
from collections.abc import Callable

import nicegui.elements.scene  # noqa: F401 - registers three.js for browsers
from nicegui import background_tasks, run, ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from remodel_console.console import Console
from remodel_console.core.cell import CellState, RobotModel, Shape
from remodel_console.core.record import Record, force_words, wire_words
from remodel_console.core.use_case import UseCase
from remodel_console.errors import CommandError
from remodel_console.watched import Meshes, Scene, Viewer


class CameraView(Element, component="static/camera.js"):
    """Shows a picture; the browser fetches it, so that pages are not slowed down."""

    def __init__(self, label: str, none: str) -> None:
        """Show nothing yet under a label; `none` stands where no picture is."""
        super().__init__()
        self._address = ""
        self._props["label"] = label
        self._props["none"] = none

    def show(self, address: str) -> None:
        """Show the picture of an address; an empty one: none."""
        if address != self._address:
            self._address = address
            self.run_method("show", address)


_EVERY_S = 0.05  # between two updates: 20 Hz
_LOST_S = 2.0  # after which a page that has not painted is sent the next update nevertheless


class _Drawing(Element, component="static/cell_view.js"):
    """The part in the browser."""


class CellView:
    """Draws a scene at 20 Hz, as long as the page is in view and paints as fast.

    Attributes:
        is_available: the browser can draw in three dimensions, and the cell describes itself.
    """

    def __init__(self, scene: Scene, meshes: Meshes, on_pick: Callable[[str], None]) -> None:
        """Begin empty; `on_pick` gets the name of a wire that is clicked."""
        self._scene = scene
        self._meshes = meshes
        self._sent = CellState()
        self._sent_s: float | None = None  # None once the page has painted what was sent
        self._can_draw = True
        self._viewer = Viewer(scene)
        self._drawing = _Drawing()
        self._drawing.on("pick", lambda event: on_pick(_text(event)))
        self._drawing.on("painted", self._on_painted)
        self._drawing.on("ready", self._on_ready)
        self._drawing.on("unavailable", self._on_unavailable)
        self._drawing.set_visibility(False)
        self._timer = ui.timer(_EVERY_S, self._send)
        ui.context.client.on_delete(lambda: self.set_shown(False))
        self.set_shown(True)

    @property
    def is_available(self) -> bool:
        """Return whether there is something to see."""
        now = self._scene.now
        return self._can_draw and bool(now.robots or now.wires)

    def set_shown(self, is_shown: bool) -> None:
        """Stop while the page is in the background, and go on."""
        self._viewer.watch(is_shown)
        self._timer.active = is_shown

    def _on_ready(self) -> None:
        """Send all again, to a browser that draws nothing yet."""
        self._sent, self._sent_s = CellState(), None

    def _on_painted(self) -> None:
        self._sent_s = None

    def _on_unavailable(self) -> None:
        self._can_draw = False
        self.set_shown(False)

    def _send(self) -> None:
        """Send what has changed since the last time."""
        is_waiting = self._sent_s is not None and time.monotonic() - self._sent_s < _LOST_S
        now, sent = self._scene.now, self._sent
        self._drawing.set_visibility(self.is_available)
        if is_waiting or now is sent:
            return
        changes: dict[str, object] = {}
        if now.robots != sent.robots:
            changes["robots"] = [
                _robot(robot.model, self._meshes) | {"prefix": robot.prefix}
                | {"at": [*robot.position, *robot.rotation]}
                for robot in now.robots
            ]  # fmt: skip
        if now.joints is not sent.joints:
            changes["joints"] = {
                name: round(value, 4)
                for name, value in now.joints.items()
                if "robots" in changes or sent.joints.get(name) != value
            }
        if now.boxes is not sent.boxes:
            changes["boxes"] = [
                {"at": [*box.position, *box.rotation], "size": box.size, "colour": box.colour}
                for box in now.boxes.values()
            ]
        wires = {
            name: {"points": line.points, "diameter": line.diameter, "colour": line.colour}
            for name, line in now.wires.items()
            if sent.wires.get(name) is not line
        }
        gone = [name for name in sent.wires if name not in now.wires]
        self._sent = now
        if changes or wires or gone:
            self._sent_s = time.monotonic()
            self._drawing.run_method("change", {**changes, "wires": wires, "gone": gone})


def _robot(model: RobotModel, known: Meshes) -> dict[str, object]:
    meshes = {file: f"/mesh/{known.number(file)}" for file in model.meshes}

    def shape(of: Shape) -> dict[str, object]:
        at = [*of.position, *of.rotation]
        return {"at": at, "size": of.size, "colour": of.colour, "mesh": meshes.get(of.mesh, "")}

    return {
        "root": model.root,
        "shapes": {link: [shape(one) for one in shapes] for link, shapes in model.shapes.items()},
        "joints": [
            {"name": j.name, "kind": j.kind, "parent": j.parent, "child": j.child, "axis": j.axis}
            | {"at": [*j.position, *j.rotation]}
            for j in model.joints
        ],
    }


def _text(event: GenericEventArguments) -> str:
    return event.args if isinstance(event.args, str) else ""


Words = Callable[[str], tuple[str, ...]]


class CellPanel:
    """Shows a cell; a wire is chosen by a click on it, or from a list."""

    def __init__(self, scene: Scene, meshes: Meshes, words: Words) -> None:
        """Build it; it is hidden as long as the cell does not describe itself.

        Args:
            scene: the cell.
            meshes: of its robots.
            words: returns lines about a wire.
        """
        self._scene = scene
        self._words_of = words
        self._wires: tuple[str, ...] = ()
        self._words: tuple[str, ...] = ()
        with ui.element("div").classes("cell-panel wide") as self._area:
            self._view = CellView(scene, meshes, self._choose)
            with ui.row().classes("cell-wire"):
                self._wire = ui.select([], label="Wire", clearable=True)
                self._wire.props("outlined dense").on_value_change(self._show_words)
                self._facts = ui.element("div").classes("wire-facts").props('role="status"')
        self._area.set_visibility(False)

    @property
    def is_available(self) -> bool:
        """Return whether the cell can be drawn here."""
        return self._view.is_available

    def set_shown(self, is_shown: bool) -> None:
        """Stop while the page is in the background, and go on."""
        self._view.set_shown(is_shown)

    def show(self) -> None:
        """Show the wires that there are now, and what is known of the one that is chosen."""
        self._area.set_visibility(self.is_available)
        wires = tuple(sorted(self._scene.now.wires))
        if wires != self._wires:
            self._wires = wires
            value = self._wire.value if self._wire.value in wires else None
            self._wire.set_options(list(wires), value=value)
        self._show_words()

    def _choose(self, wire: str) -> None:
        if wire in self._wires:
            self._wire.value = wire

    def _show_words(self) -> None:
        words = self._words_of(str(self._wire.value)) if self._wire.value else ()
        if words == self._words:
            return
        self._words = words
        self._facts.clear()
        with self._facts:
            for text in words:
                ui.label(text)


class LiveCell(CellPanel):
    """Shows the live cell, and the forces of a wire from the record of the run."""

    def __init__(self, console: Console) -> None:
        super().__init__(console.scene, console.meshes, self._about)
        self._console = console
        self._use_case: UseCase | None = None
        self._record = Record(())
        self._read_for: object = None

    def follow(self, use_case: UseCase | None) -> None:
        """Show the wires, and what has become known of the one that is chosen."""
        self._use_case = use_case
        self.show()

    def _about(self, wire: str) -> tuple[str, ...]:
        use_case = self._use_case
        words = wire_words(wire, use_case)
        if use_case is None or not use_case.run:
            return words
        task = next((one for one in use_case.tasks if one.name == wire), None)
        cause = (use_case.run, task, len(use_case.failures))
        if task is not None and cause != self._read_for:
            self._read_for = cause
            background_tasks.create(self._read(use_case.run))
        return (*words, *force_words(self._record, wire))

    async def _read(self, number: int) -> None:
        """Read the record of the run, when something of the wire has changed in it."""
        try:
            self._record = await run.io_bound(self._console.record, number)
        except CommandError:
            return  # the supervisor has ended meanwhile; the forces stay as they were
        self.show()
