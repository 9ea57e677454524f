"""What goes wrong in one run of the campaign, drawn from a seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random
from typing import Any

# How often an ability is asked for in a wire that goes well.
GOALS_OF_A_WIRE = {
    "DetectCable": 1,
    "LocateGearboxComponent": 2,
    "InsertCable": 2,
    "FixCable": 2,
    "PickCable": 2,
    "LayWire": 1,
}
WIRES = 2
# Of the first wires of the order, which are too thick for the robots.
BY_HAND = 3

# Responses that the fake cell knows as cures, beside an operator's, who is absent here.
_CURES = ("retry", "retry_with", "look_again", "new_part", "replan")
_OPERATOR = "ask_operator"
_OPERATOR_SHARE = 0.1

# Who tries again by itself.
_INSIDE = ("action", "behavior")


@dataclass(frozen=True)
class Trial:
    """One run.

    Attributes:
        kind: name of the fault; empty: nothing goes wrong.
        seed: of what was drawn.
        first_level: who is to handle it first.
        codes: names of the error codes that report it.
        cure: response that cures it; empty: none does.
        faults: parameters of the fake cell.
    """

    kind: str
    seed: int
    first_level: str = ""
    codes: tuple[str, ...] = ()
    cure: str = ""
    faults: tuple[dict[str, Any], ...] = ()

    @property
    def can_recover(self) -> bool:
        """Whether something that can be done without a person cures it."""
        return self.cure not in ("", _OPERATOR)


def drawn(row: Mapping[str, Any], seed: int) -> Trial:
    """Return a trial of a fault.

    A cure is drawn from the responses that the table lists for the fault; one fault in ten, of
    those for which an operator is asked in the end, has no other cure. A fault that action
    or behavior handle first may also pass by itself.

    Args:
        row: of remodel_msgs/config/faults.yaml.
        seed: of the draw.
    """
    kind, cause = row["fault"], row["cause"]["interface"]
    random = Random(f"{kind} {seed}")
    times = {response["do"]: response.get("times", 1) for response in row["responses"]}
    if row["first_level"] in _INSIDE:
        times.setdefault("retry", 2)
    cures = [do for do in times if do in _CURES]
    if "after" in row:  # what a behavior does by itself would end it before it shows
        cures = [do for do in cures if do not in ("retry", "look_again")]
    cure = random.choice(cures) if cures else ""
    if _OPERATOR in times and random.random() < _OPERATOR_SHARE:
        cure = _OPERATOR
    fault: dict[str, Any] = {"name": kind, "cure": cure or _OPERATOR}
    goals = GOALS_OF_A_WIRE.get(cause["ability"], 1)
    # There must be another wire left for the plan to change.
    fault["nth"] = random.randint(1, goals if cure == "replan" else WIRES * goals)
    if cure == "retry":
        fault["times"] = random.randint(1, times["retry"])
    if cure == "retry_with":
        fault["at_least"] = random.uniform(15.0, 20.0)  # what 14 N and two changes reach
    return Trial(kind, seed, row["first_level"], tuple(row["codes"]), cure, (fault,))
