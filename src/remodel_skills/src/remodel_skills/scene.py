"""What a robot must not touch: the panel as drawn or last located, and wires that were seen."""

from __future__ import annotations

from collections.abc import Callable, Set

from remodel_skills.belief_state import BeliefState
from remodel_skills.device import Device
from remodel_skills.space import CollisionCheck, HeldTip, Touch
from remodel_vision.standing import standing_wires
from remodel_work.camera import Picture
from remodel_work.geometry import Pose
from remodel_work.obstacles import Obstacles, panel_obstacles
from remodel_work.panel import Panel, PanelWire
from remodel_work.robot.arm import ToolPose


class Scene:
    """The obstacles of one robot's motions, as the cell believes them to be."""

    def __init__(
        self, device: Device, panel: Panel, belief: BeliefState, check: CollisionCheck | None
    ) -> None:
        """Begin with what is drawn; `check` of the robot's motions, None: they are not checked."""
        self._device, self._panel, self._belief, self._check = device, panel, belief, check
        # Located components, and the obstacles that follow from them; pictures, and the wires that
        # they show among these.
        self._drawn: tuple[dict[str, Pose], Obstacles] | None = None
        self._wires: tuple[tuple[Picture, ...], Obstacles, Obstacles] | None = None

    @property
    def wire(self) -> PanelWire:
        """The live wire as ordered."""
        if self._belief.feed is None:
            raise ValueError("no wire has been fed")
        return self._panel.wire(self._belief.feed.wire_id)

    def first_touch(
        self, path: Callable[[float], ToolPose], length: float, allowed: Set[str]
    ) -> Touch | None:
        """Return what of the panel a path would touch first; None: nothing, or it is not checked.

        What is drawn counts, and the wires that lay there before the live one was touched.

        Args:
            path: of the tool, from 0 to 1.
            length: of it [m].
            allowed: names of obstacles that may be touched.
        """
        if self._check is None:
            return None
        drawn = self._panel_obstacles()
        return self._check.first_touch(
            path,
            length,
            obstacles=(drawn, self._seen_wires(drawn)),
            finger_gap=self._device.gripper.gap,
            held=self._held_tip(),
            allowed=allowed,
        )

    def _panel_obstacles(self) -> Obstacles:
        """Return what stands on the plate, as drawn or as last located."""
        seen = self._belief.seen
        if self._drawn is None or self._drawn[0] != seen:
            self._drawn = dict(seen), panel_obstacles(self._panel, seen)
        return self._drawn[1]

    def _seen_wires(self, drawn: Obstacles) -> Obstacles:
        """Return the wires that stand out of what is drawn, as the overhead cameras saw them."""
        pictures = tuple(self._belief.untouched)
        if not pictures:
            return Obstacles()
        if self._wires is None or self._wires[0] != pictures or self._wires[1] is not drawn:
            self._wires = pictures, drawn, standing_wires(pictures, self._panel, drawn)
        return self._wires[2]

    def _held_tip(self) -> HeldTip | None:
        grip = self._belief.grip
        if grip is None:
            return None
        wire = self.wire
        return HeldTip(wire.id, wire.radius, grip.distance, grip.height, grip.flip)
