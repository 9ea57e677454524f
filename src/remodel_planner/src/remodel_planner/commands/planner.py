"""`rosrun remodel_planner planner SUBCOMMAND`: every command of the planner under one name."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import NoReturn

from remodel_planner.commands.options.entry import run

# Where each command is, and what it does.
_COMMANDS = {
    "import": (
        "remodel_planner.commands.import_design",
        "read a design file into the production database",
    ),
    "layout": ("remodel_planner.commands.layout", "draw the board of an order"),
    "tasks": ("remodel_planner.commands.tasks", "print how the tasks of an order decompose"),
    "plan": ("remodel_planner.commands.plan", "plan the wiring of a panel or an order"),
    "check": ("remodel_planner.commands.check", "check a plan against its problem"),
    "explain": (
        "remodel_planner.commands.explain",
        "explain a plan, or a run",
    ),
    "draw": ("remodel_planner.commands.draw", "draw a plan"),
    "charts": ("remodel_planner.commands.charts", "make a state chart of each task of a plan"),
    "export": ("remodel_planner.commands.export", "write a problem for other planners"),
    "sequence": (
        "remodel_planner.commands.sequence",
        "find the order of insertions of a cable tree",
    ),
    "run_order": (
        "remodel_planner.commands.runs.run_order",
        "place the wires of an order in the cell",
    ),
    "use_case_supervisor": (
        "remodel_planner.commands.runs.use_case_supervisor",
        "carry out orders of the production database (a node)",
    ),
    "replay": ("remodel_planner.commands.runs.replay", "play a recorded run back"),
    "expectations": (
        "remodel_planner.commands.runs.expectations",
        "print what was learned from runs about abilities",
    ),
    "product": ("remodel_planner.commands.product", "export what was done to a product"),
    "backup": ("remodel_planner.commands.backup", "back up the production database"),
    "restore": ("remodel_planner.commands.restore", "restore the production database"),
}


def main(arguments: list[str] | None = None) -> int:
    """Run a subcommand, and return its exit code; 2 if there is none of that name."""
    words = sys.argv[1:] if arguments is None else arguments
    if not words or words[0] in ("-h", "--help"):
        print(_usage(), file=sys.stdout if words else sys.stderr)
        return 0 if words else 2
    name, *rest = words
    if name not in _COMMANDS:
        known = ", ".join(_COMMANDS)
        print(f"planner: no subcommand {name}; there are: {known}", file=sys.stderr)
        return 2
    return _run(name, rest)


def alias(name: str) -> NoReturn:
    """Run a subcommand by its name of the release before, and exit with its code."""
    print(
        f"rosrun remodel_planner {name}: the name is now `rosrun remodel_planner planner {name}`; "
        "this one goes with the next release",
        file=sys.stderr,
    )
    run(lambda: _run(name, sys.argv[1:]))


def _run(name: str, words: list[str]) -> int:
    """Run a subcommand as if it were the program: nodes read the program's arguments, too."""
    sys.argv = [name, *words]
    return int(import_module(_COMMANDS[name][0]).main())


def _usage() -> str:
    width = max(map(len, _COMMANDS))
    lines = (f"  {name:{width}}  {what}" for name, (_, what) in _COMMANDS.items())
    return "\n".join(
        (
            "usage: planner SUBCOMMAND ...",
            "",
            *lines,
            "",
            "`planner SUBCOMMAND --help` prints options and exit codes.",
        )
    )
