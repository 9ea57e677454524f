"""The goals of the abilities, and the checks of them against the panel and the belief."""

from remodel_skills.goals.ability_goals import (
    CheckGoal,
    ConnectGoal,
    DetectGoal,
    ExtractGoal,
    FixGoal,
    Goal,
    InsertGoal,
    LocateGoal,
    PickGoal,
    PlaceGoal,
    RouteGoal,
)
from remodel_skills.goals.discard_goal import DiscardGoal
from remodel_skills.goals.lay_goal import LayGoal
from remodel_skills.goals.pin_goal import PlacePinGoal

__all__ = [
    "CheckGoal",
    "ConnectGoal",
    "DetectGoal",
    "DiscardGoal",
    "ExtractGoal",
    "FixGoal",
    "Goal",
    "InsertGoal",
    "LayGoal",
    "LocateGoal",
    "PickGoal",
    "PlaceGoal",
    "PlacePinGoal",
    "RouteGoal",
]
