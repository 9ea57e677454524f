"""The folders that charts lie in: what is in them, and whose a file is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from flexbe_synthesizer.core.chart.names import behavior_file
from flexbe_synthesizer.edge.chart_files import (
    LARGEST_FILE,
    chart_names,
    confined_to,
    read_chart_file,
)
from flexbe_synthesizer.errors import ChartFileError
from remodel_console.core.editor.draft import Draft, read_draft
from remodel_console.errors import CommandError, FileChangedError

# Beside a chart: what was saved of it while it had errors. No program but the editor reads it.
_KEPT = ".draft"
_READ_WITHIN_S = 10.0  # all charts of the folders; a person waits for them


@dataclass(frozen=True)
class ChartFolders:
    """Folders of charts. Files that are no charts, or cannot be read, are skipped."""

    folders: tuple[Path, ...]

    def files(self) -> tuple[str, ...]:
        """Return the names of the files in them."""
        return tuple(sorted({p.name for folder in self.folders for p in folder.glob("*.xml")}))

    def names(self) -> Iterator[tuple[str, Path]]:
        """Yield name and file of each chart.

        Raises:
            CommandError: if that takes too long.
        """
        return chart_names(self.folders, self._deadline())

    def too_large(self) -> Iterator[tuple[str, str]]:
        """Yield name and reason of each file that is not opened since it is too large."""
        for folder in self.folders:
            for path in sorted(folder.glob("*.xml")):
                if path.is_file() and path.stat().st_size > LARGEST_FILE:
                    size = f"{path.stat().st_size / 2**20:.1f} MiB"
                    yield path.name, f"{path} has {size}; charts have {LARGEST_FILE >> 20} at most"

    def kept_drafts(self) -> Iterator[tuple[str, Draft]]:
        """Yield name and draft of what was kept of charts that were never saved."""
        for folder in self.folders:
            for path in sorted(folder.glob(f"*.xml{_KEPT}")):
                file = path.with_suffix("")
                if file.exists():
                    continue
                try:
                    draft = read_draft(read_chart_file(path), str(file))
                except (ChartFileError, CommandError):
                    continue
                yield draft.chart.name, replace(draft, origin=None)

    def contents(self) -> Iterator[tuple[Path, bytes]]:
        """Yield file and content of each chart.

        Raises:
            CommandError: if that takes too long.
        """
        locate, expect_time = confined_to(self.folders), self._deadline()
        for _name, path in self.names():
            expect_time()
            try:
                yield path, read_chart_file(locate(str(path)))
            except ChartFileError:
                continue

    def expect_own(self, draft: Draft, file: Path) -> None:
        """Refuse to write a chart where another one is, or was meanwhile.

        Raises:
            CommandError: if the file or the behavior would be overwritten.
        """
        try:
            now = read_chart_file(file) if file.exists() else None
        except (ChartFileError, OSError) as error:
            raise CommandError(str(error)) from error
        if now is not None and now != draft.origin:
            raise FileChangedError(
                f"{file} was changed elsewhere since it was "
                f"{'opened' if draft.origin is None else 'loaded'}, and saving would undo that; "
                "load it again, or save this chart under another name",
                now.decode(errors="replace"),
            )
        if now is None and draft.origin is not None:
            return  # it was deleted: saving brings it back
        own = behavior_file(draft.chart.name)
        for name, path in self.names():
            is_beside = path.parent == file.parent and path.resolve() != file.resolve()
            if is_beside and behavior_file(name) == own:
                raise CommandError(
                    f"'{draft.chart.name}' and '{name}' of {path} become the same behavior; "
                    "rename one of them"
                )

    def _deadline(self) -> Callable[[], None]:
        end = time.monotonic() + _READ_WITHIN_S

        def expect_time() -> None:
            if time.monotonic() > end:
                where = ", ".join(map(str, self.folders))
                raise CommandError(
                    f"reading the chart folders takes more than {_READ_WITHIN_S:g} s; move other "
                    f"files out of {where}"
                )

        return expect_time


def kept_file(file: Path) -> Path:
    """Return where the draft of a chart is kept, beside the chart's file."""
    return file.with_name(file.name + _KEPT)
