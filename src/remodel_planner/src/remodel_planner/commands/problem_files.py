"""The files that make up a planning problem, common to the commands that need one."""

from __future__ import annotations

import argparse
from pathlib import Path

from remodel_planner.core.planning.defects import require_sound
from remodel_planner.core.planning.instance import problem_from
from remodel_planner.core.planning.plan_form import plan_from
from remodel_planner.core.planning.preferences import Preferred, apply_preferences
from remodel_planner.core.planning.problem import Plan
from remodel_planner.edge.json_file import read_json
from remodel_planner.edge.preferences_file import read_preferences
from remodel_planner.errors import InstanceError


def add_problem_options(parser: argparse.ArgumentParser) -> None:
    """Add the instance and --preferences."""
    parser.add_argument("instance", type=Path, help="problem (planbench-1, docs/planning.md)")
    parser.add_argument(
        "--preferences", type=Path, metavar="FILE", help="YAML of what a user prefers and requires"
    )


def read_problem(options: argparse.Namespace) -> Preferred:
    """Return the sound problem of the files, with its preferences.

    Raises:
        InstanceError: naming the file, and what is wrong where.
    """
    file: Path = options.instance
    try:
        preferred = Preferred(problem_from(read_json(file)), {})
        require_sound(preferred.problem)
        if options.preferences is not None:
            file = options.preferences
            preferred = apply_preferences(preferred.problem, read_preferences(file))
            require_sound(preferred.problem)
    except InstanceError as error:
        raise InstanceError(f"{file}: {error}") from error
    return preferred


def read_plan(file: Path) -> Plan:
    """Return the plan in a file.

    Raises:
        InstanceError: naming the file, and what is wrong where.
    """
    try:
        return plan_from(read_json(file))
    except InstanceError as error:
        raise InstanceError(f"{file}: {error}") from error
