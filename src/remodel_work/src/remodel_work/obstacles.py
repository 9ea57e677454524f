"""What an arm must not touch: the solids that stand on the plate, as boxes in the world."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from remodel_work.component_shape import Box
from remodel_work.fixtures import FIXTURE_RGB, clip_boxes, duct_boxes, rail_box
from remodel_work.geometry import Array, Pose, rotation_matrix
from remodel_work.panel import Panel

# The name of every solid that stands for wires: those yield.
WIRES = "the wires there"


@dataclass(frozen=True)
class Solid:
    """A box of something, world frame; `name` is of the whole, such as "duct 'D1'"."""

    name: str
    box: Box


@dataclass(frozen=True)
class Obstacles:
    """Solids, in any order."""

    solids: tuple[Solid, ...] = ()

    def nearest(self, point: Array) -> str:
        """Return the name of the solid that is nearest to a point, (3,) [m]."""
        centres, turns, halves = self._geometry
        local = np.einsum("nji,nj->ni", turns, point - centres)
        outside = np.linalg.norm(np.maximum(np.abs(local) - halves, 0.0), axis=1)
        return self.solids[int(outside.argmin())].name

    @cached_property
    def _geometry(self) -> tuple[Array, Array, Array]:
        """Of all boxes: centres (n, 3) [m], rotation matrices (n, 3, 3), half sizes (n, 3) [m]."""
        boxes = [solid.box for solid in self.solids]
        turns = [_rotation(box.rpy) for box in boxes]
        sizes = np.array([box.size for box in boxes])
        return np.array([box.centre for box in boxes]), np.array(turns), sizes / 2


def panel_obstacles(panel: Panel, seen: Mapping[str, Pose]) -> Obstacles:
    """Return the components, rails, ducts' walls and clips of a panel.

    Args:
        panel: as drawn.
        seen: frames of components in the world where they were located; others stand as drawn.
    """
    return Obstacles(tuple(_panel_solids(panel, seen)))


def _panel_solids(panel: Panel, seen: Mapping[str, Pose]) -> Iterator[Solid]:
    for component in panel.components:
        place = seen.get(component.id, panel.world_from_panel @ component.panel_from_component)
        housing = Box((0.0, 0.0, component.size[2] / 2), component.size, FIXTURE_RGB)
        yield Solid(component_name(component.id), _placed(housing, place))
    for rail in panel.rails:
        place = panel.world_from_panel @ rail.panel_from_rail
        yield Solid(f"rail {rail.id!r}", _placed(rail_box(rail), place))
    for duct in panel.ducts:
        place = panel.world_from_panel @ duct.panel_from_duct
        for wall in duct_boxes(duct, panel.ducts):
            yield Solid(duct_name(duct.id), _placed(wall, place))
    for clip in panel.clips:
        place = panel.world_from_panel @ clip.panel_from_clip
        for part in clip_boxes(clip):
            yield Solid(f"clip {clip.id!r}", _placed(part, place))


def component_name(component_id: str) -> str:
    """Return the name of a component's solid."""
    return f"component {component_id!r}"


def duct_name(duct_id: str) -> str:
    """Return the name of a duct's walls."""
    return f"duct {duct_id!r}"


def _placed(box: Box, place: Pose) -> Box:
    """Return a box of an upright frame in the world."""
    x, y, z = (float(v) for v in place.apply(np.array(box.centre)))
    roll, pitch, yaw = box.rpy
    return replace(box, centre=(x, y, z), rpy=(roll, pitch, yaw + place.yaw))


def _rotation(rpy: tuple[float, float, float]) -> Array:
    """Return the (3, 3) matrix of turns about the fixed axes x, y and z, in that order [rad]."""
    turns = []
    for axis, angle in enumerate(rpy):
        quaternion = np.zeros(4)
        quaternion[axis], quaternion[3] = math.sin(angle / 2), math.cos(angle / 2)
        turns.append(rotation_matrix(quaternion))
    about_x, about_y, about_z = turns
    return np.asarray(about_z @ about_y @ about_x)
