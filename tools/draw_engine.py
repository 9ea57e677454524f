#!/usr/bin/env python3
"""Draw the engine's tables into docs/engine.md; run it with the workspace sourced."""

from pathlib import Path
from types import SimpleNamespace

from flexbe_core.engine.supervision import _HANDLERS, AFTER, BEFORE, Rule
from flexbe_core.ros.command_hub import _COMMANDS

DOCUMENT = Path(__file__).parents[1] / "docs" / "engine.md"
BEGIN, END = "<!-- drawn by tools/draw_engine.py -->\n", "<!-- end of what is drawn -->\n"

# A message with all fields that a command may be made of.
_ANY_MESSAGE = SimpleNamespace(data=True, target="", outcome=0)


def decisions() -> str:
    """Return both tables of decisions as a flow chart."""
    lines = ["```mermaid", "flowchart TD"]
    lines += _chain("before", "before it is executed", BEFORE)
    lines += _chain("after", "with the outcome it returned", AFTER)
    return "\n".join([*lines, "```", ""])


def _chain(key: str, title: str, rules: tuple[Rule, ...]) -> list[str]:
    lines = [f"  {key}([{title}]) --> {key}0"]
    for index, rule in enumerate(rules):
        act = f'{key}{index}a["<b>{rule.act.name}</b><br/>{rule.act.value}"]'
        if index == len(rules) - 1:
            lines.append(f'  {key}{index}["{rule.name}"] --> {act}')
        else:
            lines.append(f'  {key}{index}{{"{rule.name}?"}} -- yes --> {act}')
            lines.append(f"  {key}{index} -- no --> {key}{index + 1}")
    return lines


def commands() -> str:
    """Return where each command goes."""
    rows = ["| topic | command | handled by |", "|---|---|---|"]
    for topic, make in _COMMANDS.items():
        command = type(make(_ANY_MESSAGE))
        names = "`Pause`, `Resume`" if command.__name__ == "Pause" else f"`{command.__name__}`"
        handler = _HANDLERS.get(command)
        where = (
            f"`engine/supervision.py` `{handler.__name__}`"
            if handler
            else "`engine/engine.py` `handle`"
        )
        rows.append(f"| `{topic}` | {names} | {where} |")
    return "\n".join([*rows, ""])


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
