"""The files that make up a planning problem, common to the commands that need one."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from remodel_planner.commands.database_option import add_database_option
from remodel_planner.core.order_problem import order_problem
from remodel_planner.core.planning.defects import require_sound
from remodel_planner.core.planning.instance import problem_from
from remodel_planner.core.planning.plan_form import plan_from
from remodel_planner.core.planning.preferences import Preferred, apply_preferences
from remodel_planner.core.planning.problem import Plan
from remodel_planner.core.production import Order
from remodel_planner.edge.json_file import read_json
from remodel_planner.edge.preferences_file import read_preferences
from remodel_planner.errors import InstanceError


def add_problem_options(parser: argparse.ArgumentParser) -> None:
    """Add the instance, or --order in its place, and --preferences."""
    parser.add_argument(
        "instance", type=Path, nargs="?", help="problem (planbench-1, docs/planning.md)"
    )
    parser.add_argument(
        "--order", metavar="NAME", help="order of the production database, in place of a problem"
    )
    parser.add_argument(
        "--arms", type=int, choices=(1, 2), default=2, help="that place an order (default 2)"
    )
    add_database_option(parser)
    parser.add_argument(
        "--preferences", type=Path, metavar="FILE", help="YAML of what a user prefers and requires"
    )


def read_problem(options: argparse.Namespace) -> Preferred:
    """Return the sound problem of the files or of an order, with its preferences.

    Raises:
        PlannerError: naming the file or the order, and what is wrong where.
    """
    if (options.instance is None) == (options.order is None):
        raise InstanceError("give either the file of a problem, or --order NAME")
    documents: list[tuple[str, object]] = []
    if options.instance is not None:
        with _blamed(str(options.instance)):
            preferred = Preferred(problem_from(read_json(options.instance)), {})
            require_sound(preferred.problem)
    else:
        order, stored = _read_order(options)
        with _blamed(f"order {order.name}"):
            preferred = Preferred(order_problem(order, options.arms), {})
            require_sound(preferred.problem)
        if stored is not None:
            documents.append((f"preferences of order {order.name}", stored))
    if options.preferences is not None:
        with _blamed(str(options.preferences)):
            documents.append((str(options.preferences), read_preferences(options.preferences)))
    for name, document in documents:
        with _blamed(name):
            reasons = preferred.arm_reasons
            preferred = apply_preferences(preferred.problem, document)
            preferred = replace(preferred, arm_reasons={**reasons, **preferred.arm_reasons})
            require_sound(preferred.problem)
    return preferred


def _read_order(options: argparse.Namespace) -> tuple[Order, object]:
    """Return an order of the production database, and the preferences that came with it."""
    # SQLAlchemy takes longer to load than most problems to plan, and files do not need it.
    from remodel_planner.edge.production_database import ProductionDatabase

    database = ProductionDatabase(options.database)
    try:
        return database.order(options.order), database.preferences(options.order)
    finally:
        database.close()


@contextmanager
def _blamed(source: str) -> Iterator[None]:
    """Name the source of what is malformed."""
    try:
        yield
    except InstanceError as error:
        raise InstanceError(f"{source}: {error}") from error


def read_plan(file: Path) -> Plan:
    """Return the plan in a file.

    Raises:
        InstanceError: naming the file, and what is wrong where.
    """
    try:
        return plan_from(read_json(file))
    except InstanceError as error:
        raise InstanceError(f"{file}: {error}") from error
