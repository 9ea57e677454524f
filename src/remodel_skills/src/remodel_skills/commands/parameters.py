"""Print the numbers of the skills in force: name, value, unit, where it stands, and why."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from remodel_skills.edge.parameter_files import VARIABLE, Parameter, ParameterError, read_parameters


def main(words: Sequence[str]) -> int:
    """Print a line for each number, and return the exit code."""
    options = _arguments(words)
    try:
        table = read_parameters().table
    except ParameterError as error:
        sys.stderr.write(f"parameters: {error}\n")
        return 1
    rows = [_row(each) for each in table if options.text in each.name]
    widths = [max(map(len, column), default=0) for column in list(zip(*rows, strict=True))[:-1]]
    for *cells, last in rows:
        padded = [cell.ljust(width) for cell, width in zip(cells, widths, strict=True)]
        print("  ".join([*padded, last]))
    return 0


def _row(parameter: Parameter) -> tuple[str, ...]:
    value = str(parameter.shown).replace(" ", "")
    where = parameter.file if parameter.is_own else parameter.file.rpartition("/")[2]
    text = f"{parameter.meaning}; origin: {parameter.origin}"
    return parameter.name, value, parameter.unit, where, text


def _arguments(words: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "parameters",
        description=__doc__,
        epilog=f"{VARIABLE}=FOLDER replaces single numbers by those of files there, which are "
        "named as the package's own (tool.yaml, ...); such lines show the whole path. "
        "Exit code: 0 printed, 1 a file is invalid, 2 usage error.",
    )
    parser.add_argument(
        "text", nargs="?", default="", help="print only names that contain it, such as motion."
    )
    return parser.parse_args(list(words))
