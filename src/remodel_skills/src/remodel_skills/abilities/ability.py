"""What makes a function an ability of the cell.

A function in a module directly in this folder becomes one by the decorator:

    @ability("PickCable", _pick_goal)
    def pick_cable(context: RobotContext, goal: PickGoal) -> Steps[CablePicked]:

The name is that of the action, and of the row in the table of abilities. The goal's class checks
its values when it is made, and `check` of it whether the cell can do it as it is now.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol, TypeVar

from remodel_skills import abilities
from remodel_skills.belief_state import BeliefState
from remodel_skills.parameters import Parameters
from remodel_work.geometry import Pose
from remodel_work.panel import Panel

Function = TypeVar("Function", bound=Callable[..., Any])

_MARK = "ability_of_the_cell"


class Goal(Protocol):
    """What an ability is asked for, valid from birth."""

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise AbilityError when the cell cannot take the goal as it is now.

        Whatever raises here is found before anything moves.
        """


class AbilityResult(Protocol):
    """What an ability returns: what it did, and fields named as in its action's result."""

    message: str


@dataclass(frozen=True)
class Done:
    """What an ability returns that reports nothing but a message, for a person."""

    message: str


@dataclass(frozen=True)
class CellAbility:
    """One ability.

    Attributes:
        name: of the action, such as "InsertCable".
        parse: makes the goal of a goal message and of where the panel lies; raises AbilityError.
        perform: the steps that do it, given the robots' contexts and the goal.
    """

    name: str
    parse: Callable[[Any, Pose], Any]
    perform: Callable[..., Any]


def ability(name: str, parse: Callable[[Any, Pose], Any]) -> Callable[[Function], Function]:
    """Return a decorator for the steps that do an ability."""

    def mark(perform: Function) -> Function:
        setattr(perform, _MARK, CellAbility(name, parse, perform))
        return perform

    return mark


def cell_abilities() -> dict[str, CellAbility]:
    """Return the abilities of all modules directly in this folder, by name."""
    found_here = pkgutil.iter_modules(abilities.__path__)
    names = sorted(module.name for module in found_here if not module.ispkg)
    modules = [import_module(f"{abilities.__name__}.{name}") for name in names]
    values = [value for module in modules for value in vars(module).values()]
    found = [getattr(value, _MARK) for value in values if hasattr(value, _MARK)]
    return {each.name: each for each in found}
