"""Inspects which ends of a task's wire are in their terminals."""

from __future__ import annotations

from remodel_planning.core.problem.problem import End
from remodel_supervision.core.runs.events import Settled
from remodel_supervision.core.runs.step import Settle
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.errors import HaltedError
from remodel_supervision.supervisors.gate_keeper import SUPERVISOR, GateKeeper
from remodel_supervision.supervisors.ports import Inspection, UnseenError
from remodel_supervision.supervisors.run_record import RunRecord


class TaskInspector:
    """Inspects tasks whose progress is unverified, and records what is connected."""

    def __init__(
        self,
        record: RunRecord,
        planner: WorkPlanner,
        inspection: Inspection,
        gates: GateKeeper,
    ) -> None:
        """Take the run's record, and what inspects.

        Args:
            record: of the run.
            planner: of its order.
            inspection: the ability.
            gates: let it move.
        """
        self._record = record
        self._planner = planner
        self._inspection = inspection
        self._gates = gates

    def inspect(self, name: str) -> None:
        """Inspect a task, and record which of its ends are connected, or why that is not visible.

        Raises:
            HaltedError: if the gate is closed.
            LostError: if the ability is lost; it counts as moving until everything is stopped.
        """
        self._gates.update()
        gate = self._gates.gate
        decisions = self._record.state.tasks[name].decisions
        planned = self._planner.task(name, decisions)
        connected: list[str] = []
        self._gates.enter(SUPERVISOR, f"inspecting {name}")
        try:
            for end in End:
                terminal = planned.decomposition.task.terminals[end]
                component = planned.component_of[terminal]
                if self._is_connected(name, end, component, terminal):
                    connected.append(end.letter)
            gate.end(SUPERVISOR)
        except HaltedError:
            gate.end(SUPERVISOR)
            raise
        except UnseenError as error:
            gate.end(SUPERVISOR)
            if gate.halt:
                raise HaltedError(gate.halt) from error
            self._keep(Settled(name, tuple(connected), 1, error.code, unseen=str(error)))
            self._gates.tasks.note_stop(error.goal_id)
            return
        left = self._planner.task(name, decisions, connected).left(connected)
        self._keep(Settled(name, tuple(connected), len(left)))

    def _is_connected(self, name: str, end: End, component: str, terminal: str) -> bool:
        if self._gates.gate.halt:
            raise HaltedError(self._gates.gate.halt)
        return self._inspection.is_connected(
            self._record.owner,
            name,
            end.letter,
            component,
            terminal=terminal.removeprefix(f"{component}:"),
        )

    def _keep(self, settled: Settled) -> None:
        self._record.append_if_next(Settle(settled.task), settled, while_paused=True)
