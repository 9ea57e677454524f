"""The cell in one process: its panel, its feeder, its score and its pictures, as ports."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
from remodel_msgs.msg import Panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.ros.owner import Owner
from remodel_states.core.codes import Code
from remodel_states.core.wires import WireMaterials
from remodel_supervision.errors import RefusedError
from remodel_tasks.core.task_charts.planned_tasks import Demands
from remodel_work.errors import AbilityError, CellError, PanelError
from remodel_work.ros.panel_message import panel_from
from remodel_work.routes import PlacedWires


class CellServices:
    """The services of the simulated cell; the supervisor's port, and a part of the loop.

    Attributes:
        cpu_s: CPU time in physics, vision and skills so far [s].
    """

    def __init__(
        self,
        owner: Owner,
        plant: SimulatedPlant,
        materials: WireMaterials,
        placed: PlacedWires,
        disturb: Callable[[SimulatedPlant], None],
    ) -> None:
        """Take a cell.

        Args:
            owner: runs it.
            plant: of it.
            materials: complete the wires of a panel.
            placed: the wires that lie on the panel before the order begins.
            disturb: is called when the panel is built, before anything is observed.
        """
        self._owner, self._plant, self._materials = owner, plant, materials
        self._placed, self._disturb = placed, disturb
        self.cpu_s = 0.0

    def wait(self, limit_s: float) -> None:
        """They are there."""

    def address(self) -> str:
        """Return where the cell answers."""
        return "this process"

    def load(self, panel: object, serial: str, owner: int, *, demands: Demands, keep: bool) -> None:
        """Build a panel, with the wires that lie on it; RefusedError if the cell cannot."""
        assert isinstance(panel, Panel)
        panel.serial = serial

        def build() -> None:
            self._owner.cell.admit(owner)
            self._owner.cell.load(
                panel_from(panel, self._materials),
                robots=demands.robots,
                forces_n=dict(demands.forces_n),
                placed=self._placed,
            )

        self._do(build, f"load panel {panel.name}")
        self._disturb(self._plant)

    def feed(self, wire: str, owner: int) -> None:
        """Present a piece of a wire; RefusedError if the feeder cannot."""

        def feed() -> None:
            self._owner.cell.admit(owner)
            self._owner.cell.feed(wire, "")

        self._do(feed, f"feed wire {wire}")

    def placed(self, wire: str) -> bool | None:
        """Return whether a wire is placed, by ground truth; None if there is none of it."""
        if wire not in self._plant.shapes():
            return None
        (truth,) = ground_truth(self._plant, [wire])
        return truth.placed

    # --- part of the loop

    def turn(self) -> bool:
        """Let one tick of the cell pass if an ability runs."""
        with self._timed():
            return self._owner.turn()

    def next_due_s(self) -> float:
        """Return never: between goals the scene is frozen."""
        return float("inf")

    def _do(self, action: Callable[[], None], what: str) -> None:
        """Do something in the cell; RefusedError, as its services answer."""
        try:
            with self._timed():
                action()
        except AbilityError as error:
            raise RefusedError(int(error.code), f"cannot {what}: {error}") from error
        except PanelError as error:
            raise RefusedError(int(Code.INVALID_GOAL), f"cannot {what}: {error}") from error
        except CellError as error:
            raise RefusedError(int(Code.INTERNAL), f"cannot {what}: {error}") from error

    @contextmanager
    def _timed(self) -> Iterator[None]:
        began_s = time.process_time()
        try:
            yield
        finally:
            self.cpu_s += time.process_time() - began_s


class FailurePictures:
    """Pictures of the scene when a behavior has failed; the supervisor's port `Pictures`.

    Attributes:
        kept: files, by the labels of behaviors.
    """

    def __init__(self, plant: SimulatedPlant, folder: Path | None) -> None:
        """Keep pictures in a folder; None: none."""
        self.kept: dict[str, Path] = {}
        self._plant, self._folder = plant, folder

    def begin(self) -> None:
        """Forget nothing."""

    def keep(self, run: int, label: str) -> tuple[str, ...]:
        """Take a picture of the scene, unless the wire has its place."""
        if self._folder is None or self._plant.live is None:
            return ()
        file = self._folder / f"{label}.png"
        picture = self._plant.photograph("scene").rgb
        cv2.imwrite(str(file), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
        self.kept[label] = file
        return (file.name,)
