"""The table, the plate and the components in the world."""

from __future__ import annotations

from collections.abc import Iterable

from remodel_sim.core.cell_design import Table
from remodel_sim.core.component_shape import Box, component_boxes
from remodel_sim.core.fixtures import duct_boxes
from remodel_sim.core.geometry import Pose
from remodel_sim.core.layout import WORLD_FROM_PANEL
from remodel_sim.core.panel import Channel, Panel
from remodel_sim.core.wire_colours import PLATE_RGB
from remodel_sim.physics.clips import add_clip
from remodel_sim.physics.static_body import add_described, add_static, boxes_description
from remodel_sim.physics.world import CONTACT_DAMPING, CONTACT_STIFFNESS, World

PLATE_FRICTION = 0.4
COMPONENT_FRICTION = 0.3
LANE_RGB = (0.88, 0.89, 0.88)
# Below the mouths, which are 20 mm high.
LIP_HEIGHT_M = 0.012
LIP_THICKNESS_M = 0.002
LIP_RGB = (0.62, 0.64, 0.63)
TABLE_RGB = (0.36, 0.31, 0.27)
TABLE_THICKNESS_M = 0.04


class PanelScene:
    """The bodies of one panel; components can be moved as somebody would who bumps into them."""

    def __init__(self, world: World, table: Table, panel: Panel, poses: dict[str, Pose]) -> None:
        """Build table, plate, lanes and components.

        `poses` has each component's frame in the world.
        """
        self._bullet = world.bullet
        self._components: dict[str, int] = {}
        thickness = panel.size[2]
        middle = (table.x, table.y, -thickness - TABLE_THICKNESS_M / 2)
        size = (table.length, table.width, TABLE_THICKNESS_M)
        self._static([Box(middle, size, TABLE_RGB, solid=False)], Pose.level(0, 0, 0))
        plate = Box((0, 0, -thickness / 2), panel.size, PLATE_RGB, solid=False)
        add_plate_surface(world, [plate])
        for channel in panel.channels:
            y = (channel.y_min + channel.y_max) / 2
            size = (channel.width, channel.y_max - channel.y_min, 0.0002)
            lane = Box((channel.x, y, 0.0), size, LANE_RGB, solid=False)
            self._static([lane, *_lips(channel)], WORLD_FROM_PANEL)
        for duct in panel.ducts:
            self._static(duct_boxes(duct), WORLD_FROM_PANEL @ duct.panel_from_duct)
        for clip in panel.clips:
            add_clip(world, clip, WORLD_FROM_PANEL @ clip.panel_from_clip)
        for component in panel.components:
            body = self._static(component_boxes(component), poses[component.id])
            self._bullet.changeDynamics(
                body,
                -1,
                lateralFriction=COMPONENT_FRICTION,
                contactStiffness=CONTACT_STIFFNESS,
                contactDamping=CONTACT_DAMPING,
            )
            self._components[component.id] = body

    def _static(self, boxes: Iterable[Box], pose: Pose) -> int:
        return add_static(self._bullet, boxes, pose)

    def body_of(self, component_id: str) -> int:
        """Return PyBullet's number of a component."""
        return self._components[component_id]

    def place_component(self, component_id: str, pose: Pose) -> None:
        """Put a component somewhere else, world frame."""
        self._bullet.resetBasePositionAndOrientation(
            self._components[component_id], pose.position.tolist(), pose.quaternion.tolist()
        )


def _lips(channel: Channel) -> list[Box]:
    """Low walls along both edges of a channel.

    They keep slack wire out of the gaps between components.
    """
    y = (channel.y_min + channel.y_max) / 2
    aside = channel.width / 2 - LIP_THICKNESS_M / 2
    size = (LIP_THICKNESS_M, channel.y_max - channel.y_min, LIP_HEIGHT_M)
    return [Box((channel.x + side * aside, y, LIP_HEIGHT_M / 2), size, LIP_RGB) for side in (-1, 1)]


def add_plate_surface(world: World, looks: Iterable[Box] = ()) -> int:
    """Add the plane that wires lie on, z = 0, that looks like these boxes; returns the body.

    Bullet finds two points where a link lies on a plane, and up to four on a box, which take a
    third more time. So what hangs over the plate's edge does not fall the plate's thickness.
    """
    plane = '<collision><geometry><plane normal="0 0 1"/></geometry></collision>'
    surface = add_described(world.bullet, [plane, *boxes_description(looks)], WORLD_FROM_PANEL)
    world.bullet.changeDynamics(surface, -1, lateralFriction=PLATE_FRICTION)
    return surface
