"""The file that keeps the wires by hand of each product, and which of them a person has ticked off.

The list outlives the supervisor that gave it: a person may place the wires the day after.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import Path

import msgspec

from remodel_console.edge.private_file import write_private
from remodel_console.errors import CommandError
from remodel_run.progress import HandWire

_KEPT = 1000  # products, the latest


class _Product(msgspec.Struct, frozen=True):
    wires: tuple[HandWire, ...]
    ticked: frozenset[str] = frozenset()

    @property
    def is_left(self) -> bool:
        return any(wire.name not in self.ticked for wire in self.wires)


class HandWires:
    """Holds the wires by hand, the same for all pages.

    Attributes:
        on_change: called after each change.
    """

    def __init__(self, path: Path) -> None:
        """Read the file, if it is there.

        Raises:
            ValueError: if it is no file of wires by hand.
            OSError: if it cannot be read.
        """
        self._path = path
        self._lock = threading.Lock()
        self.on_change: Callable[[], None] = lambda: None
        text = path.read_bytes() if path.exists() else b"{}"
        try:
            self._products = msgspec.json.decode(text, type=dict[str, _Product])
        except msgspec.DecodeError as error:
            raise ValueError(
                f"{path}: {error}; correct it, or delete it: then no wire by hand is ticked off"
            ) from error

    def ticked(self, product: str) -> frozenset[str]:
        """Return the names of the wires of a product, by its serial number, that are ticked off."""
        found = self._products.get(product)
        return found.ticked if found is not None else frozenset()

    def left(self) -> tuple[str, tuple[HandWire, ...]]:
        """Return the latest product of which a wire is still to be placed, and all its wires.

        Returns:
            Its serial number, empty if there is no such product.
        """
        left = ((name, each.wires) for name, each in self._products.items() if each.is_left)
        return max(enumerate(left), default=(0, ("", ())))[1]

    def keep(self, product: str, wires: tuple[HandWire, ...]) -> None:
        """Keep the wires by hand of a product; what is ticked off stays so."""
        known = self._products.get(product)
        if known is not None and known.wires == wires:
            return
        try:
            self._change(product, _Product(wires, self.ticked(product)))
        except CommandError as error:
            logging.getLogger(__name__).warning("%s", error)

    def tick(self, product: str, wire: str, *, is_placed: bool) -> None:
        """Tick a wire off, or take its tick back.

        Raises:
            CommandError: if the file cannot be written.
        """
        known = self._products.get(product, _Product(()))
        ticked = known.ticked | {wire} if is_placed else known.ticked - {wire}
        self._change(product, _Product(known.wires, ticked))
        self.on_change()

    def _change(self, product: str, changed: _Product) -> None:
        with self._lock:
            others = {key: each for key, each in self._products.items() if key != product}
            products = dict([*others.items(), (product, changed)][-_KEPT:])
            try:
                write_private(self._path, msgspec.json.encode(products).decode() + "\n")
            except OSError as error:
                raise CommandError(
                    f"the wires by hand of {product} cannot be kept: {error}"
                ) from error
            self._products = products
