"""The files that make up a planning problem, common to the commands that need one."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from remodel_planner.core.planning.defects import require_sound
from remodel_planner.core.planning.instance import problem_from
from remodel_planner.core.planning.plan_form import plan_from
from remodel_planner.core.planning.preferences import Preferred, apply_preferences
from remodel_planner.core.planning.problem import Plan, Problem
from remodel_planner.core.use_case.preparation import Prepared, prepare
from remodel_planner.core.use_case.work_order import is_order, order_from
from remodel_planner.edge.json_file import read_json
from remodel_planner.edge.use_case_files import find_use_case
from remodel_planner.edge.yaml_file import read_yaml
from remodel_planner.errors import InstanceError, blamed

_YAML = (".yaml", ".yml")


@dataclass(frozen=True)
class ProblemFiles:
    """A problem read from its files, and the order that it was made from, if it was."""

    preferred: Preferred
    prepared: Prepared | None

    @property
    def problem(self) -> Problem:
        """The problem with the preferences in it."""
        return self.preferred.problem


def add_problem_options(parser: argparse.ArgumentParser) -> None:
    """Add the instance, --preferences and --while."""
    parser.add_argument(
        "instance",
        type=Path,
        help="problem (planbench-1, docs/planning.md) or order (remodel-order-1, "
        "docs/use-cases.md), as JSON or YAML",
    )
    parser.add_argument(
        "--preferences",
        type=Path,
        metavar="FILE",
        action="append",
        default=[],
        help="YAML of what a user prefers and requires; may be repeated",
    )
    parser.add_argument(
        "--while",
        dest="situations",
        metavar="SITUATION",
        action="append",
        default=[],
        help="a situation that is present, and in which requirements with this `while` count",
    )


def read_problem(options: argparse.Namespace) -> ProblemFiles:
    """Return the sound problem of the files, with its preferences.

    Raises:
        PlannerError: naming the file, and what is wrong where.
    """
    documents = [(str(file), read_document(file)) for file in options.preferences]
    situations = frozenset(options.situations)
    file: Path = options.instance
    data = read_document(file)
    if is_order(data):
        with blamed(file):
            order = order_from(data)
            use_case = find_use_case(order.use_case)
            prepared = prepare(order, use_case, documents, situations)
        files = ProblemFiles(prepared.preferred, prepared)
    else:
        files = ProblemFiles(_stated(file, data, documents, situations), None)
    unknown = sorted(situations - files.preferred.situations)
    if unknown:
        known = ", ".join(sorted(files.preferred.situations)) or "none"
        raise InstanceError(f"--while {unknown[0]}: no requirement says so; there are {known}")
    return files


def read_order(options: argparse.Namespace) -> Prepared:
    """Return the order of the files, ready for planning.

    Raises:
        PlannerError: naming the file, and what is wrong where.
    """
    prepared = read_problem(options).prepared
    if prepared is None:
        raise InstanceError(
            f"{options.instance}: states a problem, and no tasks to decompose: give an order "
            "(remodel-order-1, docs/use-cases.md)"
        )
    return prepared


def _stated(
    file: Path, data: object, documents: list[tuple[str, object]], situations: frozenset[str]
) -> Preferred:
    """Return the sound problem that an instance states, with preferences."""
    with blamed(file):
        preferred = Preferred(problem_from(data))
        require_sound(preferred.problem)
    for name, document in documents:
        with blamed(name):
            preferred = apply_preferences(preferred, document, situations)
            require_sound(preferred.problem)
    return preferred


def read_document(file: Path) -> object:
    """Return the parsed document of a JSON file, or of a YAML file by its name.

    Raises:
        InstanceError: naming the file, and what is wrong where.
    """
    with blamed(file):
        return read_yaml(file) if file.suffix in _YAML else read_json(file)


def read_plan(file: Path) -> Plan:
    """Return the plan in a file.

    Raises:
        InstanceError: naming the file, and what is wrong where.
    """
    with blamed(file):
        return plan_from(read_json(file))
