"""The small files that the console keeps: settings, the record of commands, and wires by hand."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from flexbe_synthesizer.edge.package_path import find_packages
from remodel_console.core.access import Actor
from remodel_console.core.answer import CommandResult
from remodel_console.core.entry import Entry
from remodel_console.core.settings import Settings, read_settings, write_settings
from remodel_console.errors import CommandError
from remodel_run.progress import HandWire


def write_private(path: Path, text: str) -> None:
    """Write a file, whole or not at all; its folder is made if it is not there.

    Raises:
        OSError: if it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".new")
    draft.unlink(missing_ok=True)
    with open(draft, "x", encoding="utf-8", opener=private) as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(path)


def private(path: str, flags: int) -> int:
    """Open a file, as `open` wants it of an opener; one that is made is its owner's alone."""
    return os.open(path, flags, 0o600)


_LOG = logging.getLogger(__name__)


class Journal:
    """Appends a line for each command; several threads may write."""

    def __init__(self, path: Path) -> None:
        """Use the file at this path, made with its folder if it is not there.

        Raises:
            OSError: if it cannot be written to.
        """
        self.path = path
        self._lock = threading.Lock()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("a").close()

    def write(self, actor: Actor, answer: CommandResult) -> None:
        """Record a command and its answer; on a full disk, say so: the command is done already."""
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        line = Entry(now, actor, answer).line()
        try:
            with self._lock, self.path.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
        except OSError as error:
            words = "%s cannot be written, so this is not recorded: %s: %s"
            _LOG.error(words, self.path, error, line)


class SettingsFile:
    """Holds the settings, and keeps them in a file that only its owner can read.

    Attributes:
        now: what is configured.
        on_change: called after each change.
    """

    def __init__(self, path: Path, ros_package_path: str) -> None:
        """Read the file, if it is there.

        Raises:
            ValueError: if it is no settings file.
            OSError: if it cannot be read.
        """
        self._path = path
        self._lock = threading.Lock()
        self._ros_package_path = ros_package_path
        self.on_change: Callable[[], None] = lambda: None
        try:
            self.now = (
                read_settings(path.read_text(encoding="utf-8")) if path.exists() else Settings()
            )
        except ValueError as error:
            raise ValueError(
                f"{path}: {error}; correct it, or delete it to start with the defaults"
            ) from error

    def change(self, changed: Callable[[Settings], Settings]) -> None:
        """Keep what a function makes of the settings; several threads may change them.

        Raises:
            CommandError: if a chart folder cannot be one, or the file cannot be written.
        """
        with self._lock:
            settings = changed(self.now)
            self._keep(settings)
            self.now = settings
        self.on_change()

    def _keep(self, settings: Settings) -> None:
        for folder in settings.chart_folders:
            self._expect_folder(Path(folder))
        try:
            write_private(self._path, write_settings(settings))
        except OSError as error:
            raise CommandError(f"the settings cannot be saved: {error}") from error

    def _expect_folder(self, folder: Path) -> None:
        """Refuse what is no folder, or lies where a page may not add folders."""
        if not folder.is_dir():
            raise CommandError(f"there is no folder {folder}; create it first")
        allowed = tuple(self._grounds())
        if not any(folder.resolve().is_relative_to(ground) for ground in allowed):
            text = f"{folder} lies neither in the home folder nor in a ROS package; "
            raise CommandError(f"{text}name it when the console starts: --user-charts {folder}")

    def _grounds(self) -> Iterator[Path]:
        yield Path.home().resolve()
        packages, _warnings = find_packages(self._ros_package_path)
        yield from (package.folder.resolve() for package in packages)


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
        with self._lock:
            known = self._products.get(product)
            if known is not None and known.wires == wires:
                return
            products = self._with(product, _Product(wires, self.ticked(product)))
            self._products = products  # shown, and not tried again, where it cannot be written
            try:
                self._write(product, products)
            except CommandError as error:
                logging.getLogger(__name__).warning("%s", error)

    def tick(self, product: str, wire: str, *, is_placed: bool) -> None:
        """Tick a wire off, or take its tick back.

        Raises:
            CommandError: if the file cannot be written.
        """
        with self._lock:
            known = self._products.get(product, _Product(()))
            ticked = known.ticked | {wire} if is_placed else known.ticked - {wire}
            products = self._with(product, _Product(known.wires, ticked))
            self._write(product, products)
            self._products = products
        self.on_change()

    def _with(self, product: str, changed: _Product) -> dict[str, _Product]:
        """Return all products with one changed, as the latest."""
        others = {key: each for key, each in self._products.items() if key != product}
        return dict([*others.items(), (product, changed)][-_KEPT:])

    def _write(self, product: str, products: dict[str, _Product]) -> None:
        try:
            write_private(self._path, msgspec.json.encode(products).decode() + "\n")
        except OSError as error:
            raise CommandError(f"the wires by hand of {product} cannot be kept: {error}") from error
