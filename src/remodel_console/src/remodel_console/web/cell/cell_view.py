"""The cell in three dimensions on a page."""

from __future__ import annotations

import time
from collections.abc import Callable

import nicegui.elements.scene  # noqa: F401 - registers three.js for browsers
from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from remodel_console.core.cell.cell_state import CellState
from remodel_console.core.cell.robot_model import RobotModel, Shape
from remodel_console.scene import Meshes, Scene

_EVERY_S = 0.05  # between two updates: 20 Hz
_LOST_S = 2.0  # after which a page that has not painted is sent the next update nevertheless


class _Drawing(Element, component="../static/cell_view.js"):
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
        self._is_counted = False
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
        if is_shown != self._is_counted:
            self._is_counted = is_shown
            self._scene.add_viewer(1 if is_shown else -1)
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
