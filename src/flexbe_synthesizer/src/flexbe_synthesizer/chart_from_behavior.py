"""The command `chart_from_behavior`: a behavior's Python file back to its chart."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.machine.lift import lift
from flexbe_synthesizer.core.machine.machine_reader import InexpressibleError, read_machine
from flexbe_synthesizer.edge.files import read_regular_text, write_all
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.errors import OutputError, SynthesisError

FINE, INEXPRESSIBLE, USAGE = 0, 1, 2


def main(arguments: Sequence[str], ros_package_path: str) -> int:
    """Run the command and return its exit code: 0 fine, 1 no chart says it, 2 usage or files."""
    options = _parser().parse_args(arguments)
    packages, _warnings = find_packages(ros_package_path)
    library, _more = read_library(packages)
    file: Path = options.behavior
    try:
        machine = read_machine(_read_text(file), str(file), library)
        text = write_chart(lift(machine, str(file)))
        if options.output is None:
            sys.stdout.write(text)
        else:
            write_all({options.output: text})
            sys.stdout.write(f"chart: {options.output}\n")
    except InexpressibleError as error:
        sys.stderr.write(f"{error}\n")
        return INEXPRESSIBLE
    except (OSError, ValueError, SynthesisError) as error:
        sys.stderr.write(f"chart_from_behavior: {error}\n")
        return USAGE
    return FINE


def _read_text(file: Path) -> str:
    try:
        return read_regular_text(file)
    except (OSError, ValueError) as error:
        raise OutputError(f"{file} cannot be read: {error}") from error


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="chart_from_behavior",
        description="Read a FlexBE behavior, synthesized or made with the FlexBE App, as a chart.",
        epilog="Exit code: 0 fine, 1 no chart can express the behavior, 2 usage or files.",
    )
    parser.add_argument("behavior", type=Path, metavar="FILE_sm.py", help="the behavior's file")
    parser.add_argument("--output", type=Path, metavar="CHART.xml", help="default: standard output")
    return parser
