"""A wire that another simulator is to model too; needs nothing but Python."""

from __future__ import annotations

from dataclasses import dataclass, replace

from elastica import cantilever_drop

GRAVITY = 9.81
SAG_LOAD = 5.0  # w L^3 / EI
REPEATS = 3  # of a measurement of the speed of a long wire; the best counts


@dataclass(frozen=True)
class PeerWire:
    """A wire of equal cells.

    Attributes:
        length: [m].
        cells: number of its links.
        radius: [m].
        linear_density: [kg/m].
        bending_stiffness: EI [N m^2].
        torsional_stiffness: GJ [N m^2].
        friction: lateral friction coefficient of wire and plate together.
    """

    length: float
    cells: int
    radius: float
    linear_density: float
    bending_stiffness: float
    torsional_stiffness: float
    friction: float

    @property
    def cell(self) -> float:
        """The length of a cell [m]."""
        return self.length / self.cells

    def loaded(self) -> PeerWire:
        """Return it with such a density that w L^3 / EI is SAG_LOAD."""
        weight = SAG_LOAD * self.bending_stiffness / self.length**3
        return replace(self, linear_density=weight / GRAVITY)

    def sag_errors(self, drop: float) -> tuple[float, float]:
        """Return the error of a loaded wire's drop [m] in %: clamped there, and half a cell out."""
        weight = self.linear_density * GRAVITY
        beams = (self.length, self.length - self.cell / 2)
        raw, shifted = (
            100 * abs(drop / cantilever_drop(beam, self.bending_stiffness, weight) - 1)
            for beam in beams
        )
        return raw, shifted
