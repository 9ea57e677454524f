#!/usr/bin/env python3
"""Draw the engine's tables into docs/engine.md; run it with the workspace sourced."""

from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

from flexbe_core.engine.supervision import AFTER, BEFORE, Rule, StateCommand
from flexbe_core.ros.command_hub import _COMMANDS

DOCUMENT = Path(__file__).parents[1] / "docs" / "engine.md"
BEGIN, END = "<!-- drawn by tools/draw_engine.py -->\n", "<!-- end of what is drawn -->\n"

# A message with all fields that a command may be made of.
_ANY_MESSAGE = SimpleNamespace(data=True, target="", outcome=0)


def decisions() -> str:
    """Return both tables of decisions."""
    rows = ["| | if | then |", "|---|---|---|"]
    rows += _rules("before it is executed", BEFORE)
    rows += _rules("with the outcome it returned", AFTER)
    return "\n".join([*rows, ""])


def _rules(when: str, rules: tuple[Rule, ...]) -> list[str]:
    cells = [f"{rule.name} | **{rule.act.name}**: {rule.act.value} |" for rule in rules]
    return [f"| {'' if index else when} | {cell}" for index, cell in enumerate(cells)]


def commands() -> str:
    """Return where each command goes."""
    rows = defaultdict(list)
    for topic, make in _COMMANDS.items():
        command = type(make(_ANY_MESSAGE))
        names = "Pause, Resume" if command.__name__ == "Pause" else command.__name__
        is_for_state = command in get_args(StateCommand)
        where = "supervision.py` `apply_command" if is_for_state else "engine.py` `handle"
        rows[where].append((f"`{topic}`", names))
    lines = ["| topic | command | handled by |", "|---|---|---|"]
    for where, both in rows.items():
        topics, commands = (", ".join(dict.fromkeys(column)) for column in zip(*both, strict=True))
        lines.append(f"| {topics} | {commands} | `engine/{where}` |")
    return "\n".join([*lines, ""])


def drawn() -> str:
    """Return what is to stand between the marks of the document."""
    return f"\n{commands()}\n{decisions()}\n"


def main() -> None:
    """Put the tables into the document."""
    text = DOCUMENT.read_text(encoding="utf-8")
    head, _, rest = text.partition(BEGIN)
    tail = rest.partition(END)[2]
    DOCUMENT.write_text(f"{head}{BEGIN}{drawn()}{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
