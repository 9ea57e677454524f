"""What a run is about, and the processes that it needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from remodel_planning.core.use_case.fault import FaultTable
from remodel_run.progress import HandWire
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.supervisors.ports import (
    Abilities,
    BehaviorMaker,
    Cell,
    Engine,
    Inspection,
    Leases,
    Pictures,
)


@dataclass(frozen=True)
class Work:
    """What a run is about, beside its events.

    Attributes:
        planner: of the order.
        faults: that there are.
        panel: that the cell builds; None if it stands there.
        leases: on the tasks.
        attended: whether there is an operator who can be asked.
        reconnect_s: [s] wall time that a process that is lost or silent gets to answer again.
        by_hand: wires of the order that no robot of the cell places.
        notify: is called with each question, and when it is not answered in time; returns at once.
    """

    planner: WorkPlanner
    faults: FaultTable
    panel: object
    leases: Leases
    attended: bool
    reconnect_s: float
    by_hand: tuple[HandWire, ...] = ()
    notify: Callable[[Mapping[str, object]], None] = lambda event: None


@dataclass(frozen=True)
class Peers:
    """The processes that a run needs."""

    cell: Cell
    maker: BehaviorMaker
    engine: Engine
    abilities: Abilities
    inspection: Inspection
    pictures: Pictures

    def wait(self, limit_s: float) -> None:
        """Wait until all answer; LostError if one does not within a limit of wall time [s]."""
        for peer in (self.cell, self.maker, self.engine, self.inspection):
            peer.wait(limit_s)
