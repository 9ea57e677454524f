"""One wire rehearsed with one seed: from a board as it lies before, to what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from remodel_rehearsal.core.variation import Uncertain, Variation, vary
from remodel_rehearsal.stack import Disturb, Outcome, Setting, carry_out
from remodel_run.rehearsal import Failure, RehearsedCall, Trial
from remodel_sim.core.faults import Disturbances
from remodel_sim.physics.plant import SimulatedPlant
from remodel_states.core.codes import Code
from remodel_supervision.core.runs.events import OperationEnded, TaskBegun
from remodel_work.geometry import Pose
from remodel_work.panel import PanelWire
from remodel_work.routes import PlacedWires


@dataclass(frozen=True)
class Rehearsed:
    """What a trial leaves.

    Attributes:
        trial: what came of it.
        calls: of abilities.
        board: with the wire, if it has its place; otherwise as before.
        cpu_s: CPU time [s], of which so much was physics, vision and skills.
        physics_s: see cpu_s.
    """

    trial: Trial
    calls: tuple[RehearsedCall, ...]
    board: PlacedWires
    cpu_s: float
    physics_s: float


def rehearse_wire(
    setting: Setting,
    wire: str,
    seed: int,
    board: PlacedWires,
    table: Mapping[str, Uncertain],
    pictures: Path | None = None,
) -> Rehearsed:
    """Have one wire of an order placed on a board.

    Args:
        setting: of the order.
        wire: its name.
        seed: of chance, and of how the cell differs from its model.
        board: the wires that lie there before.
        table: what is uncertain; empty: the cell is as its model.
        pictures: folder for a picture of its failure; None: none is kept.

    Raises:
        PlannerError: if the order cannot be carried out.
    """
    outcome = carry_out(
        replace(setting, wires=(wire,)),
        seed=seed,
        placed=board,
        disturb=_varied(table, seed),
        pictures=pictures,
    )
    is_placed = wire in outcome.placed
    return Rehearsed(
        _trial(wire, seed, outcome),
        tuple(
            RehearsedCall(
                each.ability,
                each.features,
                each.error_code,
                each.elapsed_s,
                each.parameters,
            )
            for each in outcome.calls
        ),
        outcome.board if is_placed else board,
        cpu_s=outcome.total_s,
        physics_s=outcome.physics_s,
    )


def _trial(wire: str, seed: int, outcome: Outcome) -> Trial:
    """Return what the events of a run of one wire come to."""
    begun = [e for e in outcome.events if isinstance(e, TaskBegun) and e.part.is_attempt]
    ended = [e.operation for e in outcome.events if isinstance(e, OperationEnded)]
    failures = tuple(
        Failure(each.ability, Code(each.error_code).name, each.text)
        for each in ended
        if each.has_failed
    )
    is_placed, ended = wire in outcome.placed, outcome.state.ended
    if not is_placed and not failures:
        # No ability failed: the cell, or its feeder, refused.
        failures = (Failure("", "NOT_PLACED", ended.because if ended is not None else ""),)
    pictures = list(outcome.pictures.values())
    return Trial(
        wire,
        seed,
        placed=is_placed,
        attempts=len(begun),
        failures=failures,
        cell_s=outcome.cell_s,
        picture=pictures[0].name if pictures else "",
    )


def _varied(table: Mapping[str, Uncertain], seed: int) -> Disturb:
    def disturb(plant: SimulatedPlant) -> None:
        devices = [component.id for component in plant.panel.components]
        if table:
            differ(plant, vary(table, seed, plant.design.overhead_names, devices))

    return disturb


def differ(plant: SimulatedPlant, variation: Variation) -> None:
    """Have a plant differ from its model."""
    factors = variation.factors
    plant.differ(
        Disturbances(
            friction=factors["pad_friction"],
            grip=factors["grip_force"],
            light=factors["light"],
            force_noise=variation.force_noise,
            shifts={
                name: Pose.level(shift.dx, shift.dy, 0.0, shift.turn)
                for name, shift in variation.cameras.items()
            },
        ),
        {name: (shift.dx, shift.dy, shift.turn) for name, shift in variation.devices.items()},
        delivered=lambda wire: _delivered(wire, factors),
    )


def _delivered(wire: PanelWire, factors: Mapping[str, float]) -> PanelWire:
    """Return a wire as the spool gives it."""
    stiffness = factors["wire_stiffness"]
    return replace(
        wire,
        bending_stiffness=wire.bending_stiffness * stiffness,
        torsional_stiffness=wire.torsional_stiffness * stiffness,
        friction=wire.friction * factors["wire_friction"],
        rest_curvature=wire.rest_curvature * factors["wire_curvature"],
    )
