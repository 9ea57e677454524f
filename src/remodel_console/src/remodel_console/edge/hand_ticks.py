"""The file that keeps which wires by hand a person has ticked off, product by product."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from pathlib import Path

from remodel_console.edge.private_file import write_private
from remodel_console.errors import CommandError

_KEPT = 1000  # products, the latest


class HandTicks:
    """Holds the ticks, the same for all pages.

    Attributes:
        on_change: called after each change.
    """

    def __init__(self, path: Path) -> None:
        """Read the file, if it is there.

        Raises:
            ValueError: if it is no file of ticks.
            OSError: if it cannot be read.
        """
        self._path = path
        self._lock = threading.Lock()
        self.on_change: Callable[[], None] = lambda: None
        text = path.read_text(encoding="utf-8") if path.exists() else "{}"
        try:
            self._wires = {str(key): frozenset(map(str, v)) for key, v in json.loads(text).items()}
        except (ValueError, TypeError, AttributeError) as error:
            raise ValueError(
                f"{path}: {error}; correct it, or delete it: then no wire by hand is ticked off"
            ) from error

    def of(self, product: str) -> frozenset[str]:
        """Return the names of the wires of a product, by its serial number, that are ticked off."""
        return self._wires.get(product, frozenset())

    def tick(self, product: str, wire: str, *, is_placed: bool) -> None:
        """Tick a wire off, or take its tick back.

        Raises:
            CommandError: if the file cannot be written.
        """
        with self._lock:
            before = self.of(product)
            ticked = before | {wire} if is_placed else before - {wire}
            others = {key: names for key, names in self._wires.items() if key != product}
            wires = dict([*others.items(), (product, ticked)][-_KEPT:])
            kept = {key: sorted(names) for key, names in wires.items()}
            try:
                write_private(self._path, json.dumps(kept, ensure_ascii=False) + "\n")
            except OSError as error:
                raise CommandError(f"the tick of wire {wire} cannot be kept: {error}") from error
            self._wires = wires
        self.on_change()
