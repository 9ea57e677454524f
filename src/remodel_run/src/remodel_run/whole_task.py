"""What a task is wherever tasks are counted or listed: a wire, or a cable with its cores."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple


class WholeTask(NamedTuple):
    """A single wire, or a cable or twisted group: its cores are the steps of the task.

    Attributes:
        name: of the wire, or of the cable.
        wires: names; of a cable those of its cores, of which there are several.
    """

    name: str
    wires: tuple[str, ...]

    @property
    def is_cable(self) -> bool:
        """Whether it has several cores."""
        return len(self.wires) > 1

    def __str__(self) -> str:
        """Return the task as a person reads it, such as "W1" or "C1 (C1.1 C1.2)"."""
        return f"{self.name} ({' '.join(self.wires)})" if self.is_cable else self.name


def whole_tasks(wires: Iterable[tuple[str, str]]) -> tuple[WholeTask, ...]:
    """Return the tasks that wires are, in the order of their first wires.

    A cable of which there is one core only is that wire.

    Args:
        wires: names, each with the cable or twisted group that it is a core of; empty for none.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for wire, cable in wires:
        found.setdefault((cable, "" if cable else wire), []).append(wire)
    return tuple(
        WholeTask(cable if len(cores) > 1 else cores[0], tuple(cores))
        for (cable, _), cores in found.items()
    )


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, such as "1 wire" or "2 wires"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
