"""The command `synthesize`: check charts, write their behaviors, draw them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TextIO

from flexbe_synthesizer.core.draw import chart_to_dot
from flexbe_synthesizer.core.problem import errors_in
from flexbe_synthesizer.edge.graphviz import FORMATS, render_dot
from flexbe_synthesizer.edge.output_package import (
    OutputPackage,
    enclosing_package,
    output_package,
)
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.errors import OutputError, SynthesisError
from flexbe_synthesizer.synthesis import CheckedFiles, check_files, write_behaviors

FINE, CHART_ERRORS, USAGE = 0, 1, 2


def main(arguments: Sequence[str], ros_package_path: str) -> int:
    """Run the command and return its exit code: 0 fine, 1 errors in a chart, 2 usage or files."""
    options = _parser().parse_args(arguments)
    drawing: Path | None = options.draw
    if drawing is not None and (len(options.charts) > 1 or drawing.suffix not in FORMATS):
        return _fail("--draw takes one chart, and a file name that ends in .svg or .png")
    try:
        return _run(options.charts, options.check, options.output, drawing, ros_package_path)
    except SynthesisError as error:
        return _fail(str(error))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="synthesize",
        description="Check REMODEL state charts (XML) and write them as FlexBE behaviors.",
        epilog="Exit code: 0 all is fine, 1 a chart has errors, 2 wrong usage or files.",
    )
    parser.add_argument("charts", nargs="+", metavar="CHART.xml", help="charts to synthesize")
    parser.add_argument("--check", action="store_true", help="only check; write no behavior")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="ROS package to write to, made if need be (default: the one the chart lies in)",
    )
    parser.add_argument(
        "--draw", type=Path, metavar="FILE.svg", help="draw the chart, .svg or .png"
    )
    return parser


def _run(
    charts: Sequence[str],
    is_check: bool,
    output: Path | None,
    drawing: Path | None,
    ros_package_path: str,
) -> int:
    packages, package_warnings = find_packages(ros_package_path)
    library, library_warnings = read_library(packages)
    for warning in (*package_warnings, *library_warnings):
        _say(f"warning: {warning}", sys.stderr)

    @cache
    def package_of(path: str) -> OutputPackage:
        if output is not None:
            return output_package(output)
        try:
            return enclosing_package(Path(path))
        except OutputError:
            if not is_check:
                raise
            return OutputPackage("unwritten", Path(path).parent, missing={})

    files = check_files(charts, library, package_of)
    for problem in files.problems:
        _say(str(problem), sys.stderr)
    errors = errors_in(files.problems)
    if errors:
        _say(f"{len(errors)} error{'s' * (len(errors) > 1)}; nothing was written", sys.stderr)
        return CHART_ERRORS
    if drawing is not None:
        render_dot(chart_to_dot(next(iter(files.charts.values())).resolved.chart), drawing)
        _say(f"drawn: {drawing}")
    if is_check:
        _say(f"{len(files.charts)} chart{'s' * (len(files.charts) > 1)} checked, no errors")
    else:
        _write(files)
    return FINE


def _write(files: CheckedFiles) -> None:
    """Write the behaviors and say what was written."""
    changed = write_behaviors(files)
    for path in changed:
        _say(f"wrote: {path}")
    if not changed:
        _say("unchanged: every behavior is as its chart says")
    for package in {package.name: package for package in files.packages.values()}.values():
        if not package.is_exported:
            _say(
                f"warning: {package.folder / 'package.xml'} exports no <flexbe_behaviors/>; "
                "FlexBE will not find the behaviors until it does",
                sys.stderr,
            )


def _fail(reason: str) -> int:
    _say(f"synthesize: {reason}", sys.stderr)
    return USAGE


def _say(line: str, stream: TextIO | None = None) -> None:
    print(line, file=stream or sys.stdout)
