"""The cell as it is now, on pages."""

from __future__ import annotations

from nicegui import background_tasks, run

from remodel_console.console import Console
from remodel_console.core.cell.wire_history import force_words, wire_words
from remodel_console.core.use_case.record import Record
from remodel_console.core.use_case.use_case import UseCase
from remodel_console.errors import CommandError
from remodel_console.web.cell.cell_panel import CellPanel


class LiveCell(CellPanel):
    """Shows the live cell, and the forces of a wire from the record of the run."""

    def __init__(self, console: Console) -> None:
        """Build it."""
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
        recorder = self._console.recorder
        if recorder is None:
            return
        try:
            self._record = await run.io_bound(recorder.record, number) or self._record
        except CommandError:
            return  # the supervisor has ended meanwhile; the forces stay as they were
        self.show()
