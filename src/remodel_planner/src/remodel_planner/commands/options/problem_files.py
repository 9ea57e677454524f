"""The files that make up a planning problem, common to the commands that need one.

And the orders of the production database, as tasks of a use case.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from remodel_planner.commands.options.common import add_database_option
from remodel_production.errors import InfeasibleError, InstanceError, blamed
from remodel_tasks.core.orders.order_format import is_order
from remodel_tasks.core.problem.conflict import (
    Documents,
    Requirement,
    conflicts_of,
    keeping,
    requirements_in,
)
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.instance import plan_from, problem_from
from remodel_tasks.core.problem.preferences import Preferred, apply_documents
from remodel_tasks.core.problem.problem import Plan, Problem
from remodel_tasks.edge.document_files import read_json, read_yaml

# What decomposes tasks takes longer to load than a problem to plan, and problems do not need it.
if TYPE_CHECKING:
    from remodel_production.core.board.panel import Panel
    from remodel_production.core.production import Order
    from remodel_states.core.cell import CellLimits
    from remodel_tasks.core.decomposition.preparation import Prepared
    from remodel_tasks.core.orders.order_requirements import OrderRequirements
    from remodel_tasks.core.orders.work_order import WorkOrder
    from remodel_tasks.core.use_case.model import UseCase

# Tasks by hand that fill a terminal's window, but leave the lines above them on it.
_MOST_LISTED = 20


@dataclass(frozen=True)
class DesignOrder:
    """An imported order as tasks.

    Attributes:
        work: the robots' tasks, and the others by hand.
        use_case: by which they are done.
        panel: of the board.
        takes: what the cell can wire; None: that is not known.
    """

    work: WorkOrder
    use_case: UseCase
    panel: Panel
    takes: CellLimits | None


def add_design_options(parser: argparse.ArgumentParser) -> None:
    """Add --use-case, --cell and --arms."""
    parser.add_argument(
        "--use-case",
        metavar="NAME",
        help="by which an order of the database is done (default: by what its design is, "
        "docs/use-cases.md)",
    )
    parser.add_argument(
        "--cell",
        metavar="NAME",
        default="",
        help="that places an order of the database, or its file: wires that it does not take are "
        "by hand (default: the cell of the use case)",
    )
    parser.add_argument(
        "--arms",
        type=int,
        choices=(1, 2),
        default=2,
        help="that place an order of the database (default 2)",
    )


def design_order(
    stored: Order, options: argparse.Namespace, required: OrderRequirements | None = None
) -> DesignOrder:
    """Return an imported order as tasks, by the options of add_design_options.

    Raises:
        PlannerError: if the use case takes no designs, or there is no such cell.
    """
    # They take longer to load than most problems to plan, and the commands of files need none.
    from remodel_production.core.board.board import board_of
    from remodel_production.core.board.panel import panel_of
    from remodel_production.edge.design_files import catalogue_file, read_catalogue
    from remodel_tasks.core.decomposition.cell_fit import fitted
    from remodel_tasks.core.orders.board_order import board_order, kind_of
    from remodel_tasks.core.orders.order_requirements import NOTHING_REQUIRED
    from remodel_tasks.edge.cell_takes import cell_takes
    from remodel_tasks.edge.use_case_files import use_case_for

    catalogue = read_catalogue(catalogue_file())
    board = board_of(stored, catalogue)
    use_case = use_case_for(kind_of(board), options.use_case or "")
    takes, panel = cell_takes(use_case, options.cell), panel_of(board, catalogue)
    whole = board_order(board, use_case, options.arms, required or NOTHING_REQUIRED)
    return DesignOrder(fitted(whole, panel, use_case, takes), use_case, panel, takes)


def print_triage(order: WorkOrder, listed_by: str = "") -> None:
    """Print how many tasks are for the robot, by which other methods, and which are by hand.

    Nothing is printed if all tasks are single wires for the robot, by the preferred methods.

    Args:
        order: with all its tasks.
        listed_by: what prints all that are by hand, if only the first ones are to be printed.
    """
    cables, outside = order.cables, order.outside
    if not order.by_hand and not order.other_methods and not cables and not outside:
        return
    print(f"  tasks for the robot: {len(order.whole_tasks)}, by hand: {len(order.by_hand)}")
    if cables:
        cores = sum(map(len, cables.values()))
        are = "1 is a cable" if len(cables) == 1 else f"{len(cables)} are cables"
        print(f"    {are} of {cores} cores, placed one after another by one arm")
    if outside:
        such = f"such as {outside[0]}"
        what = f"{len(outside)} wires leave the plate and are no tasks of the robots, {such}"
        if len(outside) == 1:
            what = f"1 wire leaves the plate and is no task of the robots: {outside[0]}"
        print(f"    {what}")
    shown = order.by_hand[:_MOST_LISTED] if listed_by else order.by_hand
    for line in (*order.other_methods, *shown):
        print(f"    {line}")
    if len(shown) < len(order.by_hand):
        print(f"    and {len(order.by_hand) - len(shown)} more by hand ({listed_by} lists them)")


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


Build = Callable[[Documents], ProblemFiles]


class ConflictError(InfeasibleError):
    """A problem has no plan; it names requirements that contradict each other or the design.

    Attributes:
        conflicts: smallest sets of requirements that no plan keeps, without a common one; empty if
            the design alone has no plan.
        documents: the preferences of the problem.
        build: makes the problem with preferences.
    """

    def __init__(
        self,
        text: str,
        conflicts: Sequence[Sequence[Requirement]],
        documents: Documents,
        build: Build,
    ) -> None:
        """Take what the attributes are."""
        super().__init__(text)
        self.conflicts = tuple(map(tuple, conflicts))
        self.documents = documents
        self.build = build

    @property
    def conflict(self) -> tuple[Requirement, ...]:
        """The requirements of all conflicts."""
        return tuple(each for conflict in self.conflicts for each in conflict)

    @classmethod
    def of(cls, error: InfeasibleError, documents: Documents, build: Build) -> ConflictError:
        """Return the error with smallest sets of requirements that explain it."""

        def reason(kept: Sequence[Requirement]) -> str:
            try:
                build(keeping(documents, kept))
            except InfeasibleError as other:
                return str(other)
            return ""

        conflicts = conflicts_of(requirements_in(documents), lambda kept: not reason(kept))
        texts = [_explained(conflict, reason(conflict)) for conflict in conflicts]
        if len(conflicts) > 1:
            texts.insert(0, f"{len(conflicts)} contradictions that share no requirement")
        if conflicts:
            each = "one of each" if len(conflicts) > 1 else "one of them"
            texts.append(f"  drop {each}; `plan --relax` prints what each would cost")
        return cls("\n".join(texts) or str(error), conflicts, documents, build)


def _explained(conflict: Sequence[Requirement], reason: str) -> str:
    """Return why no plan keeps the requirements of a conflict, and which they are."""
    if len(conflict) == 1:
        return f"{reason}\n  the design contradicts this requirement:\n    {conflict[0]}"
    lines = "".join(f"\n    {each}" for each in conflict)
    return f"{reason}\n  no plan keeps all of these {len(conflict)} requirements:{lines}"


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
        ConflictError: if it has no plan, with a smallest set of requirements that contradict.
    """
    if (options.instance is None) == (options.order is None):
        raise InstanceError("give either the file of a problem or order, or --order NAME")
    if options.order is None and options.use_case is not None:
        raise InstanceError("--use-case is for --order NAME: the file of an order names its own")
    documents = [(str(file), read_document(file)) for file in options.preferences]
    situations = frozenset(options.situations)
    if options.order is not None:
        documents, build = _read_stored(options, documents, situations)
    else:
        build = _read_file(options.instance, situations)
    files = built(build, documents)
    unknown = sorted(situations - files.preferred.situations)
    if unknown:
        known = ", ".join(sorted(files.preferred.situations)) or "none"
        raise InstanceError(f"--while {unknown[0]}: no requirement says so; there are {known}")
    return files


def built(build: Build, documents: Documents) -> ProblemFiles:
    """Return a problem with preferences.

    Raises:
        ConflictError: if it has no plan, with a smallest set of requirements that contradict.
    """
    try:
        return build(documents)
    except InfeasibleError as error:
        raise ConflictError.of(error, documents, build) from error


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
) -> tuple[list[tuple[str, object]], Build]:
    """Return the documents of an order of the production database, and what makes its problem."""
    # SQLAlchemy takes longer to load than most problems to plan, and files do not need it.
    from remodel_production.edge.database.production_database import ProductionDatabase

    with closing(ProductionDatabase(options.database)) as database:
        stored = database.order(options.order)
        preferences = database.preferences(options.order)
    if preferences is not None:
        documents = [(f"preferences of order {stored.name}", preferences), *documents]
    return documents, build_of(stored, options, situations)


def build_of(order: Order, options: argparse.Namespace, situations: frozenset[str]) -> Build:
    """Return what makes the problem of an imported order, with preferences.

    Raises:
        PlannerError: if nothing of the order can be planned.
    """
    from remodel_tasks.core.decomposition.preparation import prepare
    from remodel_tasks.core.orders.order_requirements import (
        of_plans,
        order_requirements,
    )

    @cache
    def design_with(required: OrderRequirements) -> DesignOrder:
        return design_order(order, options, required)

    def build(preferences: Documents) -> ProblemFiles:
        with blamed(f"order {order.name}"):
            design = design_with(order_requirements(document for _, document in preferences))
            of_plan = [(name, of_plans(document)) for name, document in preferences]
            prepared = prepare(design.work, design.use_case, of_plan, situations)
        return ProblemFiles(prepared.preferred, prepared)

    return build


def _read_file(file: Path, situations: frozenset[str]) -> Build:
    """Return what makes the problem that a file states, or that its order makes."""
    data = read_document(file)
    if is_order(data):
        from remodel_tasks.core.decomposition.preparation import prepare
        from remodel_tasks.core.orders.work_order import order_from
        from remodel_tasks.edge.use_case_files import find_use_case

        with blamed(file):
            order = order_from(data)
            use_case = find_use_case(order.use_case)

        def build_order(documents: Documents) -> ProblemFiles:
            with blamed(file):
                prepared = prepare(order, use_case, documents, situations)
            return ProblemFiles(prepared.preferred, prepared)

        return build_order
    with blamed(file):
        problem = problem_from(data)

    def build_problem(documents: Documents) -> ProblemFiles:
        with blamed(file):
            require_sound(problem)
        return ProblemFiles(apply_documents(Preferred(problem), documents, situations), None)

    return build_problem


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
