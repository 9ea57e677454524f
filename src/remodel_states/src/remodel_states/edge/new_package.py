"""Read the templates of a new package, and write it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

# Folders whose files are programs.
_PROGRAMS = ("nodes", "test/rostest")


def read_templates(folder: Path) -> dict[str, str]:
    """Return the templates below a folder: path in it -> text."""
    files = sorted(path for path in folder.rglob("*.in") if path.is_file())
    return {str(file.relative_to(folder)): file.read_text(encoding="utf-8") for file in files}


def write_package(folder: Path, files: Mapping[str, str]) -> None:
    """Write the files of a new package; `folder` must not exist."""
    folder.mkdir(parents=True)
    for path, text in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        if text.startswith("#!") and path.startswith(_PROGRAMS):
            file.chmod(0o755)
