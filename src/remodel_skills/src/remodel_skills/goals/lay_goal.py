"""The goal of LayWire."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goals.checks import check_held, check_live
from remodel_skills.goals.requirements import require, require_robot
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import Panel, PanelWire, WireEnd


@dataclass(frozen=True)
class LayGoal:
    """Lead the live wire into the ducts of its route.

    Attributes:
        robot_name: of the robot that holds the free end.
        guide_name: of the robot that leads the wire.
        cable_id: the wire.
    """

    robot_name: str
    guide_name: str
    cable_id: str

    def __post_init__(self) -> None:
        """Refuse unknown robots, and one robot twice."""
        require_robot(self.robot_name)
        require(bool(self.guide_name.strip()), "guide_name is empty; it must name a second robot")
        require(
            self.robot_name != self.guide_name,
            f"robot_name and guide_name are both {self.robot_name!r}; it takes two robots",
        )

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when a robot cannot do its part; asked for each of the two."""
        check_live(self.cable_id, panel, belief)
        wire = panel.wire(self.cable_id)
        require(
            bool(wire.ducts),
            f"the route of {wire.id!r} passes no duct; carry it with RouteWire",
        )
        free = _free_end(wire, belief)
        if belief.robot == self.guide_name:
            _check_guide(belief)
        else:
            check_held(belief, free)


def _free_end(wire: PanelWire, belief: BeliefState) -> WireEnd:
    """Return the loose end of a wire; raises unless the other one is fixed."""
    loose = [end for end, state in belief.ends.items() if state is EndState.LOOSE]
    require(
        len(loose) == 1 and belief.ends[loose[0].other] is EndState.FIXED,
        f"of {wire.id!r}, end a is {belief.ends[WireEnd.A].value} and end b is "
        f"{belief.ends[WireEnd.B].value}; one must be fixed and the other one loose",
    )
    return loose[0]


def _check_guide(belief: BeliefState) -> None:
    """Raise unless the hand is empty and has an eyelet."""
    if belief.grip is not None:
        raise AbilityError(
            Code.OTHER_CABLE_HELD,
            f"{belief.robot}, which leads the wire, holds end {belief.grip.end.value}; place it "
            "first",
        )
    fingers = belief.arm.fingers
    require(
        fingers.eyelet is not None,
        f"the fingers of {belief.robot}, {fingers.name!r}, have no eyelet; lead wires with a "
        "robot whose fingers have one",
    )
