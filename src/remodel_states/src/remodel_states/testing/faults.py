"""What goes wrong in a fake cell, when, and what cures it.

A fault strikes goals of one ability, from the n-th on. It passes after some strikes, or lasts until
the response that physically cures it (those of remodel_msgs/config/faults.yaml), so that a plain
retry helps against some faults and not against others:

    retry          it passes by itself, after `times` strikes
    retry_with     a goal of any ability has `parameter` at `at_least` or more
    look_again     LocateGearboxComponent or DetectCable observes from another viewpoint
    new_part       a new piece of the wire that was struck is fed
    replan         another wire is fed first
    ask_operator   an operator mends it (cell/mend_faults)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from remodel_states.testing.world import Goal

LOOKING = frozenset({"DetectCable", "LocateGearboxComponent"})


class Behaves(Enum):
    """How a server misbehaves, independent of the ability."""

    DIES = "dies"  # its process is killed, before the deed or after it
    HANGS = "hangs"  # it never answers, only a cancel ends the goal
    CONTRADICTS = "contradicts"  # success, with an error code


class Cure(Enum):
    """What ends a fault."""

    RETRY = "retry"
    RETRY_WITH = "retry_with"
    LOOK_AGAIN = "look_again"
    NEW_PART = "new_part"
    REPLAN = "replan"
    ASK_OPERATOR = "ask_operator"


@dataclass(frozen=True)
class InjectedFault:
    """One thing that goes wrong.

    Attributes:
        name: as in faults.yaml.
        ability: whose goals it strikes.
        code: remodel_msgs/ErrorCode that they end with; unused if `behaves` is given.
        behaves: how the server misbehaves; None: it answers with the code.
        cure: what ends it.
        nth: the first goal that it strikes, counted since it was caused, from 1.
        times: how many goals it strikes; only with Cure.RETRY.
        wire: the only wire whose goals it counts and strikes; empty: any.
        parameter: of Cure.RETRY_WITH.
        at_least: value of the parameter that cures.
        seen: goals counted so far.
        struck: goals struck so far.
        victim: wire of the goal struck last; empty if its goal names none.
        is_over: whether it is cured.
    """

    name: str
    ability: str
    code: int = 0
    behaves: Behaves | None = None
    cure: Cure = Cure.RETRY
    nth: int = 1
    times: int = 1
    wire: str = ""
    parameter: str = ""
    at_least: float = 0.0
    seen: int = 0
    struck: int = 0
    victim: str = ""
    is_over: bool = False

    def __post_init__(self) -> None:
        """Check what can be wrong with it.

        Raises:
            ValueError: if a number is out of range, or what the cure needs is missing.
        """
        if self.nth < 1 or self.times < 1:
            raise ValueError(
                f"fault {self.name}: nth and times must be at least 1, found {self.nth} and "
                f"{self.times}"
            )
        if (self.cure is Cure.RETRY_WITH) != bool(self.parameter):
            raise ValueError(f"fault {self.name}: retry_with, and no other cure, has a parameter")


Faults = tuple[InjectedFault, ...]


def fault_from(
    row: Mapping[str, Any],
    codes: Mapping[str, int],
    **given: Any,  # noqa: ANN401 - fields' types
) -> InjectedFault:
    """Return the fault of a row of faults.yaml, caused as its `cause.interface` describes.

    Args:
        row: of the table.
        codes: names of error codes -> numbers.
        given: fields that are chosen, such as cure, nth or another ability that may report it.
    """
    cause = row["cause"]["interface"]
    fields = {"ability": cause["ability"], "times": cause.get("times", 1), **given}
    if fields.get("cure") is Cure.RETRY_WITH and "parameter" not in fields:
        changes = [c for response in row["responses"] for c in response.get("change", {})]
        fields["parameter"] = changes[0] if changes else ""
    return InjectedFault(
        row["fault"],
        code=codes[cause["code"]] if "code" in cause else 0,
        behaves=Behaves(cause["behaves"]) if "behaves" in cause else None,
        **fields,
    )


def at_goal(
    faults: Iterable[InjectedFault],
    ability: str,
    goal: Goal,
    included: tuple[str, ...] = (),
) -> tuple[Faults, InjectedFault | None]:
    """Return the faults after a goal came, and the one that strikes it, if any.

    Args:
        faults: those caused so far.
        ability: of the goal.
        goal: the goal.
        included: abilities that are a part of this goal, whose faults strike it too.
    """
    after, striking = [], None
    for fault in faults:
        now = _cured_by(fault, ability, goal)
        if _counts(now, (ability, *included), goal):
            now = replace(now, seen=now.seen + 1)
            if striking is None and now.seen >= now.nth:
                striking = now = _strike(now, getattr(goal, "cable_id", ""))
        after.append(now)
    return tuple(after), striking


def when_fed(faults: Iterable[InjectedFault], wire: str) -> Faults:
    """Return the faults after a new piece of a wire was fed."""
    return tuple(
        replace(fault, is_over=True)
        if fault.struck
        and (
            (fault.cure is Cure.NEW_PART and wire == (fault.victim or wire))
            or (fault.cure is Cure.REPLAN and wire != fault.victim)
        )
        else fault
        for fault in faults
    )


def when_mended(faults: Iterable[InjectedFault]) -> Faults:
    """Return the faults after an operator mended all that had shown."""
    return tuple(replace(fault, is_over=True) if fault.struck else fault for fault in faults)


def _cured_by(fault: InjectedFault, ability: str, goal: Goal) -> InjectedFault:
    is_other_view = ability in LOOKING and getattr(goal, "view", 0) > 0
    looked = fault.cure is Cure.LOOK_AGAIN and is_other_view
    changed = (
        fault.cure is Cure.RETRY_WITH
        and getattr(goal, fault.parameter, float("-inf")) >= fault.at_least
    )
    return replace(fault, is_over=True) if fault.struck and (looked or changed) else fault


def _counts(fault: InjectedFault, abilities: tuple[str, ...], goal: Goal) -> bool:
    about = not fault.wire or getattr(goal, "cable_id", "") == fault.wire
    return not fault.is_over and fault.ability in abilities and about


def _strike(fault: InjectedFault, victim: str) -> InjectedFault:
    struck = fault.struck + 1
    passes = fault.cure is Cure.RETRY and struck >= fault.times
    return replace(fault, struck=struck, victim=victim, is_over=passes)
