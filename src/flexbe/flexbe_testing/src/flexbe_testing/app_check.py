"""The command `app_check`: what the FlexBE App would lose of the packages of a workspace."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from flexbe_testing.app.judge import judge
from flexbe_testing.app.judge_state import judge_state
from flexbe_testing.app.known import Known
from flexbe_testing.app.manifest import judge_manifest
from flexbe_testing.edge.app_packages import (
    behavior_files,
    flexbe_packages,
    read_packages,
    read_source,
)
from flexbe_testing.edge.case_files import package_folder
from flexbe_testing.errors import CaseError

FINE, LOSSES, USAGE = 0, 1, 2


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    options = _parser().parse_args(arguments)
    try:
        folders = [_folder(name) for name in options.package]
        known = read_packages([*folders, *(f for f in flexbe_packages() if f not in folders)])
        losses = [loss for folder in folders for loss in _losses(folder, known)]
    except (CaseError, OSError, ValueError) as error:
        sys.stderr.write(f"app_check: {error}\n")
        return USAGE
    sys.stdout.write("".join(f"{loss}\n" for loss in losses))
    return LOSSES if losses else FINE


def _folder(name: str) -> Path:
    folder = Path(name)
    return folder.resolve() if (folder / "package.xml").is_file() else package_folder(name)


def _losses(folder: Path, known: Known) -> Iterator[str]:
    """Yield what the App would lose of a package, each with its file."""
    for file in sorted((folder / "src").rglob("*.py")):
        yield from (f"{file}: {loss}" for loss in _state_losses(file, folder.name))
    for manifest, code in behavior_files(folder):
        text = read_source(code)
        yield from (f"{code}: {loss}" for loss in judge(text, known))
        found = judge_manifest(manifest.read_text(encoding="utf-8"), text, known)
        yield from (f"{manifest}: {loss}" for loss in found)


def _state_losses(file: Path, package: str) -> list[str]:
    try:
        return list(judge_state(read_source(file), f"{package}.{file.stem}"))
    except SyntaxError as error:
        raise ValueError(f"{file}:{error.lineno}: not Python 3: {error.msg}") from error


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="app_check",
        description="Report what the FlexBE App does not see of states, and what it would lose or "
        "refuse when it loads and saves behaviors. Nothing is imported or written.",
        epilog="Exit code: 0 nothing is lost, 1 something is, 2 usage or files.",
    )
    parser.add_argument("package", nargs="+", help="name or folder of a ROS package")
    return parser
