"""The command `synthesize`: check charts, write their behaviors, draw them."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TextIO

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.export.draw import chart_to_dot
from flexbe_synthesizer.core.library.signature import Library
from flexbe_synthesizer.core.machine.lower import chart_steps
from flexbe_synthesizer.edge.files import FORMATS, read_run, render_dot, write_all
from flexbe_synthesizer.edge.output_package import (
    OutputPackage,
    enclosing_package,
    expect_found,
    output_package,
    unwritten_package,
)
from flexbe_synthesizer.edge.package_path import Inventory, read_inventory
from flexbe_synthesizer.errors import OutputError, SynthesisError
from flexbe_synthesizer.synthesis import CheckedFiles, check_files, write_behaviors

FINE, CHART_ERRORS, USAGE = 0, 1, 2


def main(arguments: Sequence[str], ros_package_path: str) -> int:
    """Run the command and return its exit code: 0 fine, 1 errors in a chart, 2 usage or files."""
    options = _parser().parse_args(arguments)
    drawing: Path | None = options.draw
    if (drawing or options.scxml) and len(options.charts) > 1:
        return _fail("--draw and --scxml take one chart")
    if drawing is not None and drawing.suffix not in FORMATS:
        return _fail("--draw takes a file name that ends in .svg or .png")
    if options.run is not None and drawing is None:
        return _fail("--run colours a drawing; name its file with --draw")
    try:
        return _run(options, ros_package_path)
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
    parser.add_argument("--json", action="store_true", help="print what was found as JSON")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="ROS package to write to, created if needed (default: the package of the chart)",
    )
    parser.add_argument(
        "--draw", type=Path, metavar="FILE.svg", help="draw the chart, .svg or .png"
    )
    parser.add_argument(
        "--run",
        type=Path,
        metavar="RUN.json",
        help='colour the path of a run: [["/Locate", "located"], ...], paths as in the engine',
    )
    parser.add_argument(
        "--scxml", type=Path, metavar="FILE.scxml", help="write the chart as W3C SCXML"
    )
    return parser


def _run(options: argparse.Namespace, ros_package_path: str) -> int:
    inventory = read_inventory(ros_package_path)
    for warning in inventory.warnings:
        _say(f"warning: {warning}", sys.stderr)

    @cache
    def package_of(path: str) -> OutputPackage:
        if options.output is not None:
            return output_package(options.output)
        try:
            return enclosing_package(Path(path))
        except OutputError:
            if not options.check:
                raise
            return unwritten_package(Path(path).parent)

    progress = _Progress(len(options.charts))
    files = check_files(options.charts, inventory.library, package_of, report=progress)
    errors = errors_in(files.problems)
    if not options.json:
        for problem in files.problems:
            _say(str(problem), sys.stderr)
    written: tuple[Path, ...] = ()
    if not errors:
        chart = next(iter(files.charts.values())).resolved.chart
        written = _export(chart, inventory.library, options)
        if not options.check:
            written += write_behaviors(files)
            _warn_of_packages(files, inventory)
    if options.json:
        _say(json.dumps(_as_json(files, written), indent=2))
    elif errors:
        _say(f"{len(errors)} error{'s' * (len(errors) > 1)}; nothing was written", sys.stderr)
    else:
        _tell(files, written, options.check)
    return CHART_ERRORS if errors else FINE


class _Progress:
    """Shows which of many charts is being checked, to a person at a terminal."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._done = 0

    def __call__(self, path: str) -> None:
        self._done += 1
        if self._count > 1 and sys.stderr.isatty():
            _say(f"[{self._done}/{max(self._count, self._done)}] {path}", sys.stderr)


def _export(chart: Chart, library: Library, options: argparse.Namespace) -> tuple[Path, ...]:
    """Draw the chart and write it as SCXML, as far as that was asked for."""
    made = []
    if options.draw is not None:
        path_taken = () if options.run is None else chart_steps(chart, read_run(options.run))
        render_dot(chart_to_dot(chart, path_taken), options.draw)
        made.append(options.draw)
    if options.scxml is not None:
        write_all({options.scxml: _scxml(chart, library)})
        made.append(options.scxml)
    return tuple(made)


def _scxml(chart: Chart, library: Library) -> str:
    """Return a chart as SCXML."""
    # Here, since lxml is a seventh of the start of a program that seldom needs it.
    from flexbe_synthesizer.core.export.scxml import ScxmlError, chart_to_scxml

    try:
        return chart_to_scxml(chart, library.error_names)
    except ScxmlError as error:
        raise OutputError(str(error)) from error


def _tell(files: CheckedFiles, written: Sequence[Path], is_check: bool) -> None:
    """Say what was written, or that there was nothing to write."""
    for path in written:
        _say(f"wrote: {path}")
    if is_check:
        _say(f"{len(files.charts)} chart{'s' * (len(files.charts) > 1)} checked, no errors")
    elif not written:
        _say("unchanged: every behavior is as its chart says")


def _warn_of_packages(files: CheckedFiles, inventory: Inventory) -> None:
    for path, one in files.charts.items():
        try:
            expect_found(one.resolved.chart.name, files.packages[path], inventory)
        except OutputError as error:
            _say(f"warning: {error}", sys.stderr)
    for package in {package.name: package for package in files.packages.values()}.values():
        if not package.is_exported:
            _say(
                f"warning: {package.folder / 'package.xml'} exports no <flexbe_behaviors/>; "
                "FlexBE will not find the behaviors until it does",
                sys.stderr,
            )


def _as_json(files: CheckedFiles, written: Sequence[Path]) -> dict[str, object]:
    """Return what was found, for programs."""
    return {
        "charts": [
            {"file": path, "name": one.resolved.chart.name} for path, one in files.charts.items()
        ],
        "problems": [
            {
                "file": problem.position.file,
                "line": problem.position.line,
                "column": problem.position.column,
                "severity": problem.code.severity.value,
                "code": problem.code.slug,
                "message": problem.message,
            }
            for problem in files.problems
        ],
        "errors": len(errors_in(files.problems)),
        "written": [str(path) for path in written],
    }


def _fail(reason: str) -> int:
    _say(f"synthesize: {reason}", sys.stderr)
    return USAGE


def _say(line: str, stream: TextIO | None = None) -> None:
    print(line, file=stream or sys.stdout)
