"""An order carried out in one process: supervisors, engine, skills and physics, without ROS.

All of it is the code that runs over ROS, behind other ports: `ros` stands for the topics,
services and actions between its parts. So equal orders, seeds and boards end in equal bits on
processors of one kind, and the physics of a run are those of the nodes with the same seed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path

from remodel_production.core.production import Order
from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_rehearsal.core.variation import Uncertain, Variation, vary
from remodel_rehearsal.ros.abilities import Exchange, Inspection, SupervisedLine
from remodel_rehearsal.ros.cell import CellClock, CellLoop, CellServices, FailurePictures
from remodel_rehearsal.ros.engine import BehaviorMaker, LocalEngine
from remodel_run.rehearsal import Failure, RehearsedCall, Trial
from remodel_sim.core.faults import Disturbances
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.ability import cell_abilities
from remodel_skills.cell import Cell
from remodel_skills.ros.owner import Owner
from remodel_skills.ros.servers import CellAbilityServer
from remodel_states.core.codes import Code
from remodel_states.edge.exported_tables import read_abilities, read_wire_materials
from remodel_supervision.core.learning.experience import Call, Experience
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Event, OperationEnded, TaskBegun
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.recorded_lessons import ability_calls
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.ros.server.work import WorkMaker
from remodel_supervision.supervisors.cell_runs import run_begun
from remodel_supervision.supervisors.ports import Peers, Work
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor
from remodel_tasks.core.condition import Features
from remodel_tasks.core.use_case.model import UseCase
from remodel_tasks.edge.fault_file import read_faults
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import PanelWire
from remodel_work.ros.panel_message import panel_from
from remodel_work.routes import PlacedWires

# No other supervisor wants the cell or the tasks of a rehearsal [s of wall time].
_LEASE_S = 1e6
# Nothing is lost in one process; so long [s] is what the ports of lost processes are given.
_RECONNECT_S = 1.0
# As the supervisor's own option --search, of an idle machine with two cores [s].
_SEARCH_S = 0.3

Disturb = Callable[[SimulatedPlant], None]


def _undisturbed(_: SimulatedPlant) -> None:
    """Leave the cell as it is."""


@dataclass(frozen=True)
class Setting:
    """What is carried out, and where.

    Attributes:
        order: of a design.
        cell: name or file of the cell; empty: that of the use case.
        use_case: name; empty: the default of such designs.
        wires: names of those that are placed, or how many, from the first of those that are for
            robots; 0: all.
        preferences: the order's document of preferences; None for none.
        force_n: limit of pushes [N] in place of that of the use case, as far as terminals bear it;
            0: that of the use case.
        longer_m: by which the wires are cut longer than the board needs them [m].
    """

    order: Order
    cell: str = ""
    use_case: str = ""
    wires: tuple[str, ...] | int = 0
    preferences: object = None
    force_n: float = 0.0
    longer_m: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """What came of a run.

    Attributes:
        state: of the run at its end.
        events: of the run.
        placed: the wires that have their place, by the ground truth.
        calls: of abilities, as learning takes them.
        board: the wires that lie on the panel at its end.
        pictures: of behaviors that failed, by their labels, such as "W3-1-whole".
        cell_s: time that the run took in the cell [s].
        physics_s: CPU time in physics and vision [s].
        total_s: CPU time of the whole run [s].
    """

    state: RunState
    events: tuple[Event, ...]
    placed: frozenset[str]
    calls: tuple[Call, ...]
    board: PlacedWires
    pictures: dict[str, Path] = field(default_factory=dict)
    cell_s: float = 0.0
    physics_s: float = 0.0
    total_s: float = 0.0

    @property
    def board_hash(self) -> str:
        """A hash of where all wires lie, to the last bit."""
        found = sha256()
        for name, wire in sorted(self.board.parked.items()):
            found.update(name.encode() + wire.nodes.tobytes())
        return found.hexdigest()[:16]


def carry_out(
    setting: Setting,
    *,
    seed: int,
    placed: PlacedWires | None = None,
    disturb: Disturb = _undisturbed,
    pictures: Path | None = None,
    watch: Callable[[RunState], None] = lambda state: None,
) -> Outcome:
    """Carry out an order in a new cell.

    Args:
        setting: what is carried out.
        seed: of the cell's chance: curvature of wires, noise of pictures.
        placed: wires that lie on the panel before; None: none.
        disturb: is called with the plant when the panel is built.
        pictures: folder for pictures of failures; None: none are kept.
        watch: called with the state of the run whenever it has changed.

    Raises:
        PlannerError: if the order cannot be carried out in this cell.
    """
    began_s = time.process_time()
    with ExitStack() as closing:
        database = _database(setting, closing)
        maker = _work_maker(database, setting)
        ownership = CellOwnership(database, maker.cell, "rehearsal", "rehearsal", lease_s=_LEASE_S)
        owned = ownership.acquire()
        assert isinstance(owned, Owned), "no other process has this database"
        work = _work(maker, setting, owned.token)
        design = read_cell(setting.cell or work.planner.use_case.designs.cell)
        materials = read_wire_materials()
        clock = CellClock()
        closing.callback(clock.close)
        loop = CellLoop(clock)
        plant = SimulatedPlant(panel_from(work.panel, materials), design=design, seed=seed)
        plant.on_time = clock.advance
        cell = Cell(plant)
        closing.callback(cell.close)
        owner = Owner(cell, clock)
        exchange = Exchange()
        rows = read_abilities()
        servers = [
            CellAbilityServer(rows[name], steps, owner, exchange)
            for name, steps in cell_abilities().items()
        ]
        services = CellServices(owner, plant, materials, placed or PlacedWires(), disturb)
        line = SupervisedLine(exchange)
        behaviors = BehaviorMaker()
        engine = LocalEngine(clock, behaviors, line)
        exchange.on_end = engine.wake
        loop.parts += [engine, line, services]
        shown = FailurePictures(plant, pictures)
        peers = Peers(
            services, behaviors, engine, exchange, Inspection(exchange, loop), pictures=shown
        )
        log = RunLog(database)
        begun = run_begun(setting.order.name, work, maker.cell)
        run, begun = log.begin(begun, owned.token)
        record = RunRecord(run, owned.token, state_after([begun]), log, loop=loop)
        supervisor = UseCaseSupervisor(
            record, loop, work, peers, on_change=lambda: watch(record.state)
        )
        line.supervisor = supervisor
        state = supervisor.supervise()
        owner.stop()
        del servers
        truths = ground_truth(plant, list(plant.shapes()))
        return Outcome(
            state,
            tuple(kept.event for kept in log.events(run)),
            frozenset(each.wire_id for each in truths if each.placed),
            ability_calls(database),
            PlacedWires(plant.shapes(), dict(cell.context.belief.occupied)),
            pictures=shown.kept,
            cell_s=clock.now_s,
            physics_s=services.cpu_s,
            total_s=time.process_time() - began_s,
        )


def planned_wires(setting: Setting) -> dict[str, str]:
    """Return the wires that robots place, in their order, and the end of each that is first.

    The end is a or b; empty: the planner chooses it.

    Raises:
        PlannerError: if the order cannot be carried out in this cell.
    """
    with ExitStack() as closing:
        maker = _work_maker(_database(setting, closing), setting)
        planner = _work(maker, setting, owner=0).planner
        first = {task.name: task.first for task in planner.order.tasks}
        ends = {name: "" if end is None else end.name.lower() for name, end in first.items()}
        return {name: ends[name] for name in planner.plan(list(first))}


def use_case_of(setting: Setting) -> UseCase:
    """Return the use case by which an order is carried out; raises PlannerError."""
    with ExitStack() as closing:
        maker = _work_maker(_database(setting, closing), setting)
        return _work(maker, setting, owner=0).planner.use_case


def _database(setting: Setting, closing: ExitStack) -> ProductionDatabase:
    """Return a database in memory with the order, for as long as the run takes."""
    database = ProductionDatabase("sqlite://")
    closing.callback(database.close)
    database.add_order(setting.order, setting.preferences)
    return database


def _work(maker: WorkMaker, setting: Setting, owner: int) -> Work:
    """Return what is carried out, with what the setting has otherwise."""
    work = maker.work(setting.order.name, setting.use_case, setting.wires, owner)
    for wire in work.panel.wires:
        wire.length += setting.longer_m
    if setting.force_n:
        work.planner.experience = _FixedForce(work.planner.use_case, setting.force_n)
    return work


class _FixedForce(Experience):
    """No experience, but for one limit of all pushes [N]."""

    def __init__(self, use_case: UseCase, force_n: float) -> None:
        super().__init__(use_case)
        self._force_n = force_n

    def parameters(
        self, ability: str, features: Features, limits: Mapping[str, float], seed: str
    ) -> dict[str, float]:
        """Return the limit of a push, no more than the terminal bears."""
        if ability != "InsertCable":
            return {}
        return {"force_limit": min(self._force_n, limits.get("force_limit", self._force_n))}


def _work_maker(database: ProductionDatabase, setting: Setting) -> WorkMaker:
    return WorkMaker(
        database,
        read_faults(),
        cell="rehearsal",
        use_case=setting.use_case,
        attended=False,
        reconnect_s=_RECONNECT_S,
        lease_s=_LEASE_S,
        search_s=_SEARCH_S,
        cell_design=lambda: setting.cell,
        clock=lambda: 0.0,
    )


# One wire with one seed: from a board as it lies before, to what came of it


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
