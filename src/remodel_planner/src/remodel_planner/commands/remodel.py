"""`remodel SUBCOMMAND`: every command of the project under one name, which is on the PATH."""

from __future__ import annotations

import sys
from importlib import import_module

# Where each command is, and what it does.
COMMANDS = {
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
    "rehearse": (
        "remodel_planner.commands.rehearse",
        "carry an order out in the simulated cell, many times, before the robot does",
    ),
    "run": (
        "remodel_planner.commands.runs.run_order",
        "place the wires of an order in the cell",
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
    if name not in COMMANDS:
        known = ", ".join(COMMANDS)
        print(f"remodel: no subcommand {name}; there are: {known}", file=sys.stderr)
        return 2
    return _run(name, rest)


def _run(name: str, words: list[str]) -> int:
    """Run a subcommand as if it were the program: nodes read the program's arguments, too."""
    sys.argv = [name, *words]
    return int(import_module(COMMANDS[name][0]).main())


def _usage() -> str:
    width = max(map(len, COMMANDS))
    lines = (f"  {name:{width}}  {what}" for name, (_, what) in COMMANDS.items())
    return "\n".join(
        (
            "usage: remodel SUBCOMMAND ...",
            "",
            *lines,
            "",
            "`remodel SUBCOMMAND --help` prints options and exit codes.",
        )
    )
