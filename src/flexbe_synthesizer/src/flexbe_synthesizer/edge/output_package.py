"""The ROS package that behaviors are written to."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.chart_reader import read_chart_name
from flexbe_synthesizer.core.export.certificate import read_chart_place
from flexbe_synthesizer.core.library.sources import AUTHOR, read_manifest
from flexbe_synthesizer.core.machine.machine_reader import written_name
from flexbe_synthesizer.edge.chart_files import read_chart_file
from flexbe_synthesizer.edge.files import read_regular, read_regular_text
from flexbe_synthesizer.edge.package_path import Inventory, read_package
from flexbe_synthesizer.errors import ChartFileError, OutputError

_PACKAGE_NAME = re.compile(r"[a-z][a-z0-9_]*\Z")
_PACKAGE_XML = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.1.0</version>
  <description>FlexBE behaviors synthesized from state charts.</description>
  <maintainer email="remodel-planner@users.noreply.github.com">{author}</maintainer>
  <license>BSD-3-Clause</license>

  <buildtool_depend>catkin</buildtool_depend>
  <exec_depend>flexbe_core</exec_depend>

  <export>
    <flexbe_behaviors/>
  </export>
</package>
"""


@dataclass(frozen=True)
class OutputPackage:
    """A package for behaviors: its name, its folder, and the files that it still lacks."""

    name: str
    folder: Path
    missing: Mapping[Path, str]
    is_exported: bool = True

    def code_path(self, behavior: str) -> Path:
        """Return the Python file of a behavior."""
        return self.folder / "src" / self.name / f"{names.behavior_module(behavior)}.py"

    def certificate_path(self, behavior: str) -> Path:
        """Return the certificate of a behavior."""
        return self.folder / "certificate" / f"{names.behavior_file(behavior)}.yaml"

    def manifest_path(self, behavior: str) -> Path:
        """Return the manifest of a behavior."""
        return self.folder / "manifest" / f"{names.behavior_file(behavior)}.xml"


def output_package(folder: Path) -> OutputPackage:
    """Return the package of a folder; a folder without a package.xml becomes a new package.

    Raises:
        OutputError: if the folder cannot be a package.
    """
    missing: dict[Path, str] = {}
    is_exported = True
    if os.path.exists(folder / "package.xml"):  # no error for names that are too long
        try:
            package = read_package(folder)
        except (ValueError, OSError) as error:
            raise OutputError(str(error)) from error
        name, is_exported = package.name, package.has_behaviors
    else:
        name = os.path.basename(os.path.realpath(folder))
        missing[folder / "package.xml"] = _PACKAGE_XML.format(name=name, author=AUTHOR)
    if not _PACKAGE_NAME.match(name):
        raise OutputError(
            f"{folder} cannot be a ROS package: '{name}' is no package name; give a folder whose "
            "name is of small letters, digits and '_', starting with a letter"
        )
    init = folder / "src" / name / "__init__.py"
    if not os.path.exists(init):
        missing[init] = f'"""Behaviors of the package {name}."""\n'
    return OutputPackage(name, folder, missing, is_exported)


def package_for(chart: Path, others: Path) -> OutputPackage:
    """Return the package whose folder `charts/` a chart lies in; else the one for all others.

    Args:
        chart: the chart's file.
        others: folder of the package for charts that lie in no other one.

    Raises:
        OutputError: if the folder cannot be a package.
    """
    for folder in chart.resolve().parents:
        if folder.name == "charts" and (folder.parent / "package.xml").is_file():
            return output_package(folder.parent)
    return output_package(others)


def unwritten_package(folder: Path) -> OutputPackage:
    """Return what stands for a package where charts are only checked."""
    return OutputPackage("unwritten", folder, missing={})


def enclosing_package(path: Path) -> OutputPackage:
    """Return the package that a file lies in.

    Raises:
        OutputError: if it lies in none.
    """
    for folder in path.resolve().parents:
        if (folder / "package.xml").is_file():
            return output_package(folder)
    raise OutputError(f"{path} lies in no ROS package; name the package to write to with --output")


# Whose the files of a behavior are: no chart may overwrite the behavior of another one


def chart_place(chart: str, package: OutputPackage) -> str:
    """Return the path of a chart's file as seen from the folder of a package."""
    return os.path.relpath(os.path.realpath(chart), os.path.realpath(package.folder))


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
