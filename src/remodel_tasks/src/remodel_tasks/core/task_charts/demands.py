"""What the charts of tasks demand of a cell, so that it can refuse an order before it moves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.model import Chart, State, walk_nodes
from remodel_states.core.contract import ROBOT_FIELDS

# Parameter of states that limits a force.
_FORCE = "force_limit"


@dataclass(frozen=True)
class Demands:
    """What goals of an order ask for.

    Attributes:
        robots: names, sorted.
        forces_n: abilities with the greatest `force_limit` [N] of their goals, sorted by name.
    """

    robots: tuple[str, ...] = ()
    forces_n: tuple[tuple[str, float], ...] = ()


def demands_of(charts: Iterable[Chart]) -> Demands:
    """Return what the states of charts demand, as far as the charts themselves state it."""
    robots: set[str] = set()
    forces_n: dict[str, float] = {}
    for chart in charts:
        for node in walk_nodes(chart):
            if not isinstance(node, State):
                continue
            ability = node.type.removesuffix("State")
            for param in node.params:
                if param.name in ROBOT_FIELDS:
                    robots.add(str(param.value))
                elif param.name == _FORCE and isinstance(param.value, int | float):
                    forces_n[ability] = max(forces_n.get(ability, 0.0), float(param.value))
    return Demands(tuple(sorted(robots)), tuple(sorted(forces_n.items())))
