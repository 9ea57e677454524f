"""The belief state: what the cell derives from its actions and observations, not ground truth."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from remodel_vision.wire_ends import TipObservation
from remodel_work.camera import Picture, View
from remodel_work.geometry import Array, Pose
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN, Kinematics, ToolPose
from remodel_work.routes import PlacedWires, TerminalKey


class EndState(Enum):
    """Where the cell has brought an end of the live wire."""

    LOOSE = "loose"
    SEATED = "seated"  # pushed in, clamp open
    FIXED = "fixed"  # clamp closed


# Of a wire that the magazine presents.
NO_CHANNEL = ""


@dataclass(frozen=True)
class Feed:
    """How the live wire was presented.

    Attributes:
        wire_id: the live wire.
        channel_id: where the feeder laid it; NO_CHANNEL: the magazine presented it.
        direction: +1 when it runs from end a towards +y, else -1.
    """

    wire_id: str
    channel_id: str
    direction: int

    @property
    def by_magazine(self) -> bool:
        """Whether the magazine presented it: it hangs, and no channel leads it."""
        return self.channel_id == NO_CHANNEL


@dataclass(frozen=True)
class Grip:
    """What the fingers hold.

    Attributes:
        end: of the live wire.
        distance: from the tip to the tool centre along the wire [m].
        height: of the wire's axis above the tool centre [m].
        flip: direction of the tip relative to the hand's x axis, 0 or pi [rad].
        tool: the tool pose of the grasp.
    """

    end: WireEnd
    distance: float
    height: float
    flip: float
    tool: ToolPose

    @staticmethod
    def of_tip(end: WireEnd, tip: Pose) -> Grip:
        """Return the grip that lays a tip down at a pose, x out of the wire, world frame."""
        x, y, z = (float(v) for v in tip.apply(np.array([-GRASP_DISTANCE_M, 0.0, 0.0])))
        return Grip(
            end=end,
            distance=GRASP_DISTANCE_M,
            height=0.0,
            flip=0.0,
            tool=ToolPose(x, y, z, tip.yaw),
        )


@dataclass
class BeliefState:
    """The belief about one panel, as one robot of the cell keeps it.

    The robots of a cell share what the containers hold: those are changed, never replaced.

    Attributes:
        robot: whose hand it is about.
        arm: that robot's.
        feed: the live wire; None before the first.
        hands: what each robot's fingers hold, by its name; nothing of an empty hand.
        engaged: the opening (world frame) into which the held end has been pushed at least a little.
        ends: of the live wire.
        tips: last sightings of its loose ends, until the wire is touched.
        expected: where the tips of its loose ends should be, (3,) [m], world frame, by the cell's
            own actions.
        picked_at: where each end was last grasped: there it can be laid down again.
        occupied: which wire end each terminal holds, over all wires.
        fed: every wire of which a piece is in the cell, in the order of feeding.
        in_clips: where clips hold the live wire, (3,) [m] each, world frame; nearest to its loose
            end the last.
        seen: frames of components in the world, as they were last located.
        panel_at: the panel's frame in the world, as it was last registered; empty before.
        untouched: the last picture of each overhead camera from before the live wire was touched;
            empty: none.
    """

    robot: str = "robot_1"
    arm: Kinematics = PANDA_AT_ORIGIN
    feed: Feed | None = None
    hands: dict[str, Grip] = field(default_factory=dict)
    engaged: Pose | None = None
    ends: dict[WireEnd, EndState] = field(default_factory=dict)
    tips: dict[WireEnd, TipObservation] = field(default_factory=dict)
    expected: dict[WireEnd, Array] = field(default_factory=dict)
    picked_at: dict[WireEnd, Grip] = field(default_factory=dict)
    occupied: dict[TerminalKey, tuple[str, WireEnd]] = field(default_factory=dict)
    fed: list[str] = field(default_factory=list)
    in_clips: list[Array] = field(default_factory=list)
    seen: dict[str, Pose] = field(default_factory=dict)
    panel_at: list[Pose] = field(default_factory=list)
    untouched: list[Picture] = field(default_factory=list)

    def beside(self, robot: str, arm: Kinematics) -> BeliefState:
        """Return the belief state of another robot of the same cell."""
        return replace(self, robot=robot, arm=arm, engaged=None)

    @property
    def grip(self) -> Grip | None:
        """What the robot's own fingers hold; None while the hand is empty."""
        return self.hands.get(self.robot)

    @grip.setter
    def grip(self, grip: Grip | None) -> None:
        self.hands.pop(self.robot, None)
        if grip is not None:
            self.hands[self.robot] = grip

    @property
    def by_magazine(self) -> bool:
        """Whether the magazine presented the live wire."""
        return self.feed is not None and self.feed.by_magazine

    def board_before(self, view: View) -> Picture | None:
        """Return a camera's last picture from before the live wire was touched; None: it has none.

        `view` is that of an overhead camera.
        """
        return next((each for each in self.untouched if each.view.is_at(view)), None)

    @property
    def is_touched(self) -> bool:
        """Whether a hand has gripped the live wire since it was fed."""
        return bool(self.picked_at)

    def presents(self, wire_id: str, channel_id: str) -> bool:
        """Return whether a piece of a wire lies in a channel as the feeder has laid it."""
        feed = self.feed
        lies_there = feed is not None and (feed.wire_id, feed.channel_id) == (wire_id, channel_id)
        return lies_there and not self.is_touched

    def start_wire(self, feed: Feed, expected: dict[WireEnd, Array]) -> None:
        """Note that a wire lies in its channel, both ends loose."""
        self.feed = feed
        self.expected.clear()
        self.expected.update(expected)
        self.picked_at.clear()
        self.ends.update({WireEnd.A: EndState.LOOSE, WireEnd.B: EndState.LOOSE})
        self.tips.clear()
        self.in_clips.clear()
        self.untouched.clear()
        if feed.wire_id not in self.fed:
            self.fed.append(feed.wire_id)

    def note_board(self, picture: Picture) -> None:
        """Keep an overhead picture if the live wire has not been touched."""
        if self.feed is not None and not self.is_touched:
            others = [each for each in self.untouched if not each.view.is_at(picture.view)]
            self.untouched[:] = [*others, picture]

    def resume_wire(
        self,
        feed: Feed,
        expected: dict[WireEnd, Array],
        fixed: frozenset[WireEnd],
        lay_at: dict[WireEnd, Grip],
    ) -> None:
        """Note that a wire of earlier is live again; `lay_at` has where its ends can be laid."""
        self.start_wire(feed, expected)
        self.picked_at.update(lay_at)
        for wire, end in self.occupied.values():
            if wire == feed.wire_id:
                self.ends[end] = EndState.FIXED if end in fixed else EndState.SEATED

    def end_wire(self, wire_id: str) -> None:
        """Note that no piece of the live wire is left."""
        self.feed = self.engaged = None
        live = (self.hands, self.ends, self.tips, self.expected, self.picked_at, self.in_clips)
        for known in live:
            known.clear()
        for key in [k for k, v in self.occupied.items() if v[0] == wire_id]:
            del self.occupied[key]
        if wire_id in self.fed:
            self.fed.remove(wire_id)

    def restore(self, placed: PlacedWires) -> None:
        """Note the wires that lay on the panel before the cell was restarted."""
        self.occupied.update(placed.occupied)
        self.fed.extend(placed.parked)

    def seat(self, end: WireEnd, terminal: TerminalKey) -> None:
        """Note that an end of the live wire sits in a terminal."""
        self.ends[end] = EndState.SEATED
        self.occupied[terminal] = (self._live(), end)

    def loosen(self, end: WireEnd) -> None:
        """Note that an end of the live wire is out of its terminal."""
        self.ends[end] = EndState.LOOSE
        mine = (self._live(), end)
        for key in [k for k, v in self.occupied.items() if v == mine]:
            del self.occupied[key]

    def _live(self) -> str:
        if self.feed is None:
            raise ValueError("no wire has been fed")
        return self.feed.wire_id
