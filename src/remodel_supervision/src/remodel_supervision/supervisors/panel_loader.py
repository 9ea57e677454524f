"""Has the cell build the product's panel, once per process of the cell."""

from __future__ import annotations

from remodel_states.core.codes import Code
from remodel_supervision.core.runs.events import PanelLoaded
from remodel_supervision.errors import RefusedError
from remodel_supervision.supervisors.gate_keeper import SUPERVISOR, GateKeeper
from remodel_supervision.supervisors.ports import Cell, Work
from remodel_supervision.supervisors.run_record import RunRecord


class PanelLoader:
    """Loads the panel of one run."""

    def __init__(self, record: RunRecord, work: Work, cell: Cell, gates: GateKeeper) -> None:
        """Begin without a panel.

        Args:
            record: of the run.
            work: what the run is about.
            cell: that builds the panel.
            gates: let it be built.
        """
        self._record = record
        self._work = work
        self._cell = cell
        self._gates = gates
        # Where the cell answered that has the panel; another address is another process.
        self._loaded_at = ""

    def load(self) -> None:
        """Have the cell build the panel, unless this cell process has it.

        Raises:
            RefusedError: if the cell cannot build it, or cannot do what the order asks for.
        """
        if self._work.panel is None or self._cell.address() == self._loaded_at:
            return
        state = self._record.state
        # A cell that began later may have built it first, and placed wires on it.
        keep = state.keep_panel or self._record.insist(self._work.leases.begun_elsewhere)
        self._gates.enter(SUPERVISOR, "loading the panel")
        try:
            self._cell.load(
                self._work.panel,
                state.serial,
                self._record.owner,
                demands=self._work.planner.demands,
                keep=keep,
            )
        except RefusedError as error:
            raise RefusedError(error.code, f"{error}{_remedy(error, state.use_case)}") from error
        finally:
            self._gates.gate.end(SUPERVISOR)
        self._record.append(PanelLoaded(state.serial))
        self._loaded_at = self._cell.address()

    def forget(self) -> None:
        """Assume that no cell has the panel: the one that had it may have been lost."""
        self._loaded_at = ""


def _remedy(error: RefusedError, use_case: str) -> str:
    """Return what a person can do about a panel that does not fit the cell."""
    if error.code != Code.INVALID_GOAL:
        return ""
    return (
        f"\nNothing has moved. Correct the design or use case {use_case}, or choose another cell "
        "or use case (remodel run --use-case)."
    )
