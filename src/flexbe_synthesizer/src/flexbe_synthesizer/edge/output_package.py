"""The ROS package that behaviors are written to."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.library.manifest import AUTHOR
from flexbe_synthesizer.edge.package_path import read_package
from flexbe_synthesizer.errors import OutputError

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
    if (folder / "package.xml").exists():
        try:
            package = read_package(folder)
        except (ValueError, OSError) as error:
            raise OutputError(str(error)) from error
        name, is_exported = package.name, package.has_behaviors
    else:
        name = folder.resolve().name
        missing[folder / "package.xml"] = _PACKAGE_XML.format(name=name, author=AUTHOR)
    if not _PACKAGE_NAME.match(name):
        raise OutputError(
            f"{folder} cannot be a ROS package: '{name}' is no package name; give a folder whose "
            "name is of small letters, digits and '_', starting with a letter"
        )
    init = folder / "src" / name / "__init__.py"
    if not init.exists():
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
