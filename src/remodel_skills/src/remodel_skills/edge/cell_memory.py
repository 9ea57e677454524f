"""What a cell restores after a restart: placed wires, as a real one does, its owner, the time.

The live wire is not among it: who handled it is dead, and the feeder presents a new one.
"""

from __future__ import annotations

import hashlib
import json
import os
import struct
from pathlib import Path

import numpy as np

from remodel_work.errors import MemoryFileError
from remodel_work.panel import Panel, WireEnd
from remodel_work.routes import ParkedWire, PlacedWires

_TIME = struct.Struct("<d")


class CellMemory:
    """A folder with the wires of one panel, the newest owner's token, and the time."""

    def __init__(self, folder: Path) -> None:
        """Open a folder, or make it.

        Raises:
            MemoryFileError: if it cannot be made or written to.
        """
        self._wires = folder / "wires.json"
        self._owner = folder / "owner"
        self._stored: dict[Path, str] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._clock = os.open(folder / "clock", os.O_RDWR | os.O_CREAT, 0o644)
            self._folder = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        except OSError as error:
            raise MemoryFileError(f"memory: {folder} cannot be written to: {error}") from error

    def close(self) -> None:
        """Close the folder; what is in it stays."""
        os.close(self._clock)
        os.close(self._folder)

    @property
    def time_s(self) -> float:
        """The simulated time that was kept last [s]; 0 if none was."""
        kept = os.pread(self._clock, _TIME.size, 0)
        return float(_TIME.unpack(kept)[0]) if len(kept) == _TIME.size else 0.0

    def keep_time(self, now_s: float) -> None:
        """Keep the simulated time [s]."""
        os.pwrite(self._clock, _TIME.pack(now_s), 0)

    @property
    def owner(self) -> int:
        """The newest token of an owner that was kept; 0 if none was.

        Raises:
            MemoryFileError: if the file is not what `keep_owner` has written.
        """
        try:
            return int(self._owner.read_text(encoding="ascii"))
        except FileNotFoundError:
            return 0
        except (OSError, ValueError) as error:
            raise MemoryFileError(
                f"memory: {self._owner} is not what a cell has kept: {error}; remove it"
            ) from error

    def keep_owner(self, owner: int) -> None:
        """Keep the newest token of an owner; raises MemoryFileError."""
        self._store(self._owner, str(owner))

    def keep(self, panel: Panel, placed: PlacedWires) -> None:
        """Keep the wires that lie on a panel, all or none of them.

        Raises:
            MemoryFileError: if the folder cannot be written to.
        """
        content = {
            "panel": _mark(panel),
            "parked": {
                name: {
                    "nodes": wire.nodes.tolist(),
                    "fixed": sorted(end.value for end in wire.fixed),
                }
                for name, wire in placed.parked.items()
            },
            "occupied": [
                [*terminal, wire, end.value] for terminal, (wire, end) in placed.occupied.items()
            ],
        }
        self._store(self._wires, json.dumps(content))

    def _store(self, file: Path, content: str) -> None:
        """Replace a file's content, so that neither a kill nor a power cut leaves half of it."""
        if self._stored.get(file) == content:
            return
        written = file.with_suffix(".new")
        try:
            with written.open("w", encoding="utf-8") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            written.replace(file)
            os.fsync(self._folder)
        except OSError as error:
            raise MemoryFileError(f"memory: {file} cannot be written to: {error}") from error
        self._stored[file] = content

    def placed(self, panel: Panel) -> PlacedWires:
        """Return the wires that lie on a panel; none if another panel, or nothing, was kept.

        Raises:
            MemoryFileError: if the file is not what `keep` has written.
        """
        try:
            content = json.loads(self._wires.read_text(encoding="utf-8"))
            if content["panel"] != _mark(panel):
                return PlacedWires()
            return PlacedWires(
                {
                    name: ParkedWire(
                        np.array(wire["nodes"]).reshape(-1, 3),
                        frozenset(map(WireEnd, wire["fixed"])),
                    )
                    for name, wire in content["parked"].items()
                },
                {
                    (component, terminal): (wire, WireEnd(end))
                    for component, terminal, wire, end in content["occupied"]
                },
            )
        except FileNotFoundError:
            return PlacedWires()
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise MemoryFileError(
                f"memory: {self._wires} is not what a cell has kept: {error!r}; take it away"
            ) from error


def _mark(panel: Panel) -> str:
    """Return a hash of all fields of a panel: no two panels share it."""
    return hashlib.sha256(repr(panel).encode()).hexdigest()
