"""Whose the files of a behavior are: no chart may overwrite the behavior of another one."""

from __future__ import annotations

import os
from pathlib import Path

from flexbe_synthesizer.core.chart.chart_reader import read_chart_name
from flexbe_synthesizer.core.export.certificate import read_chart_place
from flexbe_synthesizer.core.library.manifest import read_manifest
from flexbe_synthesizer.core.machine.manual_sections import written_name
from flexbe_synthesizer.edge.chart_files import read_chart_file
from flexbe_synthesizer.edge.inventory import Inventory
from flexbe_synthesizer.edge.output_package import OutputPackage
from flexbe_synthesizer.edge.regular_file import read_regular, read_regular_text
from flexbe_synthesizer.errors import ChartFileError, OutputError


def chart_place(chart: str, package: OutputPackage) -> str:
    """Return the path of a chart's file as seen from the folder of a package."""
    return os.path.relpath(Path(chart).resolve(), package.folder.resolve())


def expect_own(name: str, chart: str, package: OutputPackage) -> None:
    """Refuse to write the behavior of a chart over that of another chart.

    Args:
        name: of the chart.
        chart: its file.
        package: where its behavior is written.

    Raises:
        OutputError: if the files hold another behavior, were synthesized from another chart file
            that still has a chart of this name, or cannot be read.
    """
    try:
        _expect_name(name, package)
        _expect_chart(name, Path(chart), package)
    except (OSError, ValueError) as error:
        raise OutputError(f"the behavior '{name}' cannot be written: {error}") from error


def expect_found(name: str, package: OutputPackage, inventory: Inventory) -> None:
    """Refuse to write a behavior that the engine would not run, since it finds another one first.

    Args:
        name: of the behavior.
        package: where it is written.
        inventory: what is on the ROS package path.

    Raises:
        OutputError: if a package before this one has a behavior of this name.
    """
    homes = {behavior.package for behavior in inventory.library.behaviors if behavior.name == name}
    rank = inventory.rank(package.folder)
    for other in inventory.packages:
        if other.folder.resolve() == package.folder.resolve():
            return
        if other.name in homes and inventory.rank(other.folder) <= rank:
            raise OutputError(
                f"the engine would not run the behavior '{name}' that is written to "
                f"{package.folder}: {other.folder} has one of that name, and comes first on the "
                "ROS package path; rename the chart, or delete the other behavior"
            )


def _expect_name(name: str, package: OutputPackage) -> None:
    """Refuse if the files hold a behavior of another name."""
    manifest, code = package.manifest_path(name), package.code_path(name)
    found = read_manifest(read_regular(manifest), str(manifest)) if manifest.exists() else None
    there = read_regular(code).decode() if code.exists() else ""
    if manifest.exists() and found is None:
        raise OutputError(f"{manifest} is no manifest of a behavior; move it away")
    for path, other in ((manifest, found.name if found else name), (code, written_name(there))):
        if other is not None and other != name:
            raise OutputError(
                f"{path} belongs to the behavior '{other}', and '{name}' would be written over it; "
                f"give the chart another name, or delete the files of '{other}'"
            )


def _expect_chart(name: str, chart: Path, package: OutputPackage) -> None:
    """Refuse if the files are from another chart file that still has a chart of this name."""
    certificate = package.certificate_path(name)
    place = read_chart_place(read_regular_text(certificate)) if certificate.exists() else None
    if place is None:
        return
    first = (package.folder.resolve() / place).resolve()
    if first != chart.resolve() and _has_chart(first, name):
        raise OutputError(
            f"{chart} and {first} both have the name '{name}', and its behavior in "
            f"{package.folder} is from the latter; rename one of the charts, or delete the one "
            "that is not needed"
        )


def _has_chart(path: Path, name: str) -> bool:
    """Return whether a file can be read and holds a chart of a name."""
    try:
        return read_chart_name(read_chart_file(path)) == name
    except ChartFileError:
        return False
