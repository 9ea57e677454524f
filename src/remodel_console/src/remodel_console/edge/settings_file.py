"""The file that keeps the configuration."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

from flexbe_synthesizer.edge.package_path import find_packages
from remodel_console.core.settings import Settings, read_settings, write_settings
from remodel_console.edge.private_file import write_private
from remodel_console.errors import CommandError


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
