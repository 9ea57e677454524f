"""Find a component in pictures: by its label or, in a cell without labels, by its shape."""

from __future__ import annotations

import numpy as np

from remodel_skills.robot_context import RobotContext
from remodel_states.core.codes import Code
from remodel_vision.component_observation import ComponentObservation
from remodel_vision.device_pose import DeviceView, locate_device, search_device
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import Picture
from remodel_work.component_shape import label_corners
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Component

# So much of a device's top, around its middle, is to be in the pictures of a hand with a wire.
IN_VIEW = 0.8


class ComponentViews:
    """The pictures that show one component well.

    Attributes:
        component: that is searched for.
    """

    def __init__(self, context: RobotContext, component: Component) -> None:
        """Begin without pictures."""
        self._context = context
        self.component = component
        self._labels: list[LabelView] = []
        self._devices: list[DeviceView] = []

    def __len__(self) -> int:
        """Return the number of pictures."""
        return len(self._labels) + len(self._devices)

    def add(self, picture: Picture, near: Pose) -> ComponentObservation | None:
        """Locate the component by a picture and the earlier ones; None: this one is left out.

        Args:
            picture: that may show it.
            near: about where it stands, world frame.
        """
        component, panel = self.component, self._context.panel
        if not self._context.cell.labels:
            device = search_device(picture, panel, component, near)
            if device is None:
                return None
            devices = [*self._devices, device]
            observation = locate_device(component, devices)
            self._devices = devices if observation.clear else self._devices
            return observation if observation.clear else None
        corners = find_labels(picture, panel.components).get(component.marker_id)
        if corners is None and picture.view.sees(near.apply(label_corners(component)), 0.0):
            corners = search_label(picture, component, near)
        if corners is None:
            return None
        labels = [*self._labels, LabelView(picture, corners)]
        observation = locate_component(component, labels)
        self._labels = labels if observation.clear else self._labels
        return observation if observation.clear else None


def to_be_seen(context: RobotContext, component: Component) -> Array:
    """Return what of a component pictures should show, (4, 3) [m], component frame."""
    if context.cell.labels:
        return label_corners(component)
    depth, width, height = component.size
    corners = np.array([[-depth, width], [depth, width], [depth, -width], [-depth, -width]])
    return np.column_stack([IN_VIEW * corners / 2, np.full(4, height)])


def expected_place(context: RobotContext, component: Component) -> Pose:
    """Return where a component should stand, world frame.

    In a cell without labels it follows from where the panel lies, by the camera from above.
    """
    if context.cell.labels:
        return context.panel.world_from_panel @ component.panel_from_component
    if not context.belief.panel_at:
        find_panel(context, context.cameras.take_overhead_picture())
    return context.belief.panel_at[-1] @ component.panel_from_component


def find_panel(context: RobotContext, picture: Picture) -> None:
    """Note where the panel lies, by a picture with depth from above.

    Raises COMPONENT_NOT_FOUND when it does not show the panel.
    """
    found = register_panel(picture, context.panel)
    if found is None:
        raise AbilityError(
            Code.COMPONENT_NOT_FOUND,
            f"the depth camera does not show panel {context.panel.name!r} within 12 mm and 3 deg "
            "of its place; put it there, and clear the view",
        )
    context.belief.panel_at[:] = [found]
