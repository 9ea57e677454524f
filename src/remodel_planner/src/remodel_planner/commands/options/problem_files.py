"""The files that make up a planning problem, common to the commands that need one."""

from __future__ import annotations

import argparse
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from remodel_planner.commands.options.database_option import add_database_option
from remodel_planner.commands.options.design_orders import add_design_options, design_order
from remodel_planning.core.decomposition.preparation import Prepared, prepare
from remodel_planning.core.orders.work_order import is_order, order_from
from remodel_planning.core.problem.defects import require_sound
from remodel_planning.core.problem.instance import problem_from
from remodel_planning.core.problem.plan_form import plan_from
from remodel_planning.core.problem.preferences import Preferred, apply_preferences
from remodel_planning.core.problem.problem import Plan, Problem
from remodel_planning.edge.json_file import read_json
from remodel_planning.edge.use_case_files import find_use_case
from remodel_planning.edge.yaml_file import read_yaml
from remodel_production.errors import InstanceError, blamed

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
    """Add the instance, or --order in its place, --preferences and --while."""
    parser.add_argument(
        "instance",
        type=Path,
        nargs="?",
        help="problem (planbench-1, docs/planning.md) or order (remodel-order-1, "
        "docs/use-cases.md), as JSON or YAML",
    )
    parser.add_argument(
        "--order", metavar="NAME", help="order of the production database, in place of a file"
    )
    add_design_options(parser)
    add_database_option(parser)
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
    """Return the sound problem of the files or of an order, with its preferences.

    Raises:
        PlannerError: naming the file or the order, and what is wrong where.
    """
    if (options.instance is None) == (options.order is None):
        raise InstanceError("give either the file of a problem or order, or --order NAME")
    if options.order is None and options.use_case is not None:
        raise InstanceError("--use-case is for --order NAME: the file of an order names its own")
    documents = [(str(file), read_document(file)) for file in options.preferences]
    situations = frozenset(options.situations)
    if options.order is not None:
        files = _read_stored(options, documents, situations)
    else:
        files = _read_file(options.instance, documents, situations)
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
            f"{options.instance}: states a problem, and no tasks to decompose: give the file of an "
            "order (remodel-order-1, docs/use-cases.md), or --order NAME"
        )
    return prepared


def _read_stored(
    options: argparse.Namespace,
    documents: list[tuple[str, object]],
    situations: frozenset[str],
) -> ProblemFiles:
    """Return the problem that an order of the production database makes."""
    # SQLAlchemy takes longer to load than most problems to plan, and files do not need it.
    from remodel_production.edge.database.production_database import ProductionDatabase

    with closing(ProductionDatabase(options.database)) as database:
        stored = database.order(options.order)
        preferences = database.preferences(options.order)
    if preferences is not None:
        documents = [(f"preferences of order {stored.name}", preferences), *documents]
    with blamed(f"order {stored.name}"):
        order, use_case = design_order(stored, options)
        prepared = prepare(order, use_case, documents, situations)
    return ProblemFiles(prepared.preferred, prepared)


def _read_file(
    file: Path, documents: list[tuple[str, object]], situations: frozenset[str]
) -> ProblemFiles:
    """Return the problem that a file states, or that its order makes."""
    data = read_document(file)
    if is_order(data):
        with blamed(file):
            order = order_from(data)
            use_case = find_use_case(order.use_case)
            prepared = prepare(order, use_case, documents, situations)
        return ProblemFiles(prepared.preferred, prepared)
    with blamed(file):
        problem = problem_from(data)
    return ProblemFiles(_preferred(file, problem, documents, situations), None)


def _preferred(
    source: Path | str,
    problem: Problem,
    documents: list[tuple[str, object]],
    situations: frozenset[str],
) -> Preferred:
    """Return a problem that is sound, with preferences."""
    with blamed(source):
        preferred = Preferred(problem)
        require_sound(problem)
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
