"""What is uncertain about a cell, and the boards and trials that rehearsals keep.

The uncertain quantities are those of config/uncertainty.yaml, and of a user's own file.

Boards and trials lie in a folder or an object store, under the hash of what they are. A board has
the hash of its content; a trial that of everything that it follows from: order, cell, wire, seed,
board, what is uncertain, and the sources of this workspace. So what was computed once is never
computed again, and a rehearsal that was cut short goes on from what is there. Any URL of fsspec is
a place: a folder, s3://, gs://, sftp://, memory://.
"""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar
from uuid import uuid4

import fsspec
import msgspec
import numpy as np
import rospkg
import yaml

from remodel_production.errors import PlannerError
from remodel_rehearsal.core.variation import QUANTITIES, Uncertain
from remodel_rehearsal.stack import Setting
from remodel_run.rehearsal import RehearsedCall, Trial
from remodel_work.panel import WireEnd
from remodel_work.routes import ParkedWire, PlacedWires


class RehearsalError(PlannerError):
    """A rehearsal cannot be done as it is asked for."""


def read_uncertainty(own: Path | None = None) -> Mapping[str, Uncertain]:
    """Return the quantities by name, those of a file of the user's own in place of the shipped.

    Raises:
        RehearsalError: if the file cannot be read, or has something else in it.
    """
    shipped = Path(rospkg.RosPack().get_path("remodel_rehearsal")) / "config" / "uncertainty.yaml"
    rows = _rows(shipped)
    for name, changes in (_rows(own) if own is not None else {}).items():
        if name not in QUANTITIES:
            there_are = ", ".join(QUANTITIES)
            raise RehearsalError(f"{own}: no quantity {name}; there are: {there_are}")
        if not isinstance(changes, Mapping):
            raise RehearsalError(f"{own}: {name} is {changes!r}; needed: {{spread: NUMBER, ...}}")
        rows[name] = {**rows[name], **changes}
    found = {}
    for name, row in rows.items():
        try:
            found[name] = msgspec.convert(row, Uncertain)
        except (msgspec.ValidationError, ValueError) as error:
            raise RehearsalError(f"{own or shipped}: {name}: {error}") from error
    return found


def _rows(file: Path) -> dict[str, object]:
    try:
        rows = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RehearsalError(f"{file}: {error}") from error
    if not isinstance(rows, dict):
        raise RehearsalError(f"{file} is no table of quantities: {{NAME: {{spread: NUMBER}}}}")
    return rows


T = TypeVar("T")


class _Parked(msgspec.Struct, frozen=True):
    nodes: bytes
    fixed: tuple[str, ...]


class _Board(msgspec.Struct, frozen=True):
    parked: dict[str, _Parked]
    occupied: tuple[tuple[str, str, str, str], ...]


class KeptTrial(msgspec.Struct, frozen=True):
    """What is kept of a trial.

    Attributes:
        trial: what came of it.
        calls: of abilities.
        board: hash of the board after it.
        cpu_s: CPU time that it took [s].
        physics_s: of which so much was physics, vision and skills [s].
    """

    trial: Trial
    calls: tuple[RehearsedCall, ...]
    board: str
    cpu_s: float
    physics_s: float


class TrialStore:
    """What rehearsals have computed."""

    def __init__(self, url: str) -> None:
        """Open a place.

        Raises:
            RehearsalError: if it cannot be opened, or made.
        """
        self.url = url
        try:
            self._files, self._root = fsspec.core.url_to_fs(url)
            for kind in ("boards", "trials", "pictures"):
                self._files.makedirs(f"{self._root}/{kind}", exist_ok=True)
        except (OSError, ValueError, ImportError) as error:
            raise RehearsalError(f"states {url} cannot be kept: {error}") from error

    def put_board(self, board: PlacedWires) -> str:
        """Keep a board, and return its hash."""
        content = msgspec.msgpack.encode(
            _Board(
                {
                    name: _Parked(
                        np.ascontiguousarray(wire.nodes, dtype="<f8").tobytes(),
                        tuple(sorted(end.value for end in wire.fixed)),
                    )
                    for name, wire in sorted(board.parked.items())
                },
                tuple(
                    (*terminal, wire, end.value)
                    for terminal, (wire, end) in sorted(board.occupied.items())
                ),
            )
        )
        key = sha256(content).hexdigest()
        self._put(f"boards/{key}", content)
        return key

    def board(self, key: str) -> PlacedWires:
        """Return a board by its hash; RehearsalError if it is not there."""
        found = self._read(f"boards/{key}", _Board)
        if found is None:
            raise RehearsalError(f"{self.url} has no board {key}")
        return PlacedWires(
            {
                name: ParkedWire(
                    np.frombuffer(wire.nodes, dtype="<f8").reshape(-1, 3).copy(),
                    frozenset(map(WireEnd, wire.fixed)),
                )
                for name, wire in found.parked.items()
            },
            {
                (component, terminal): (wire, WireEnd(end))
                for component, terminal, wire, end in found.occupied
            },
        )

    def put_trial(self, key: str, kept: KeptTrial) -> None:
        """Keep a trial under the hash of what it follows from."""
        self._put(f"trials/{key}", msgspec.json.encode(kept))

    def trial(self, key: str) -> KeptTrial | None:
        """Return a trial; None if it was not made."""
        return self._read(f"trials/{key}", KeptTrial)

    def put_picture(self, file: Path) -> str:
        """Keep a picture, and return its name: the hash of its content."""
        content = file.read_bytes()
        name = f"{sha256(content).hexdigest()[:24]}.png"
        self._put(f"pictures/{name}", content)
        return name

    def picture(self, name: str) -> bytes:
        """Return a picture by its name."""
        return bytes(self._files.cat_file(f"{self._root}/pictures/{name}"))

    def _put(self, place: str, content: bytes) -> None:
        """Write a file whole: a process that is killed leaves at most a part beside it."""
        path = f"{self._root}/{place}"
        if not self._files.exists(path):
            part = f"{path}.{uuid4().hex}.part"
            self._files.pipe_file(part, content)
            self._files.mv(part, path)

    def _read(self, place: str, kind: type[T]) -> T | None:
        try:
            content = self._files.cat_file(f"{self._root}/{place}")
        except FileNotFoundError:
            return None
        try:
            if place.startswith("boards/"):
                return msgspec.msgpack.decode(content, type=kind)
            return msgspec.json.decode(content, type=kind)
        except msgspec.DecodeError as error:
            raise RehearsalError(
                f"{self.url}/{place} is not what a rehearsal has kept: {error}; remove it"
            ) from error


def mark_of(setting: Setting, table: Mapping[str, Uncertain], sources: str) -> str:
    """Return a hash of what all trials of a rehearsal follow from."""
    text = repr((setting, sorted(table.items()), sources))
    return sha256(text.encode()).hexdigest()


def trial_key(mark: str, wire: str, seed: int, board: str, how: str) -> str:
    """Return the hash of what a trial follows from."""
    return sha256(f"{mark} {wire} {seed} {board} {how}".encode()).hexdigest()


# The packages whose code decides what comes of a trial.
_CODE = (
    "flexbe_core",
    "flexbe_synthesizer",
    "remodel_behaviors",
    "remodel_production",
    "remodel_rehearsal",
    "remodel_sim",
    "remodel_skills",
    "remodel_states",
    "remodel_supervision",
    "remodel_tasks",
    "remodel_vision",
    "remodel_work",
)


def hash_of_sources() -> str:
    """Return a hash of the code, and of the tables and numbers, that trials are made by."""
    found = sha256()
    packages = rospkg.RosPack()
    for name in _CODE:
        spec, shared = find_spec(name), Path(packages.get_path(name))
        code = list(spec.submodule_search_locations or ()) if spec is not None else []
        for folder in (*map(Path, code), shared / "config", shared / "parameters"):
            for file in sorted(folder.rglob("*")):
                if file.suffix in (".py", ".yaml"):
                    found.update(file.read_bytes())
    return found.hexdigest()
