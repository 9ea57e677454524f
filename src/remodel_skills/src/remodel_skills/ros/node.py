"""The node of a cell: ability servers and services over a plant, simulated or real."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rospy
import yaml
from genpy import MessageException
from sensor_msgs.msg import CameraInfo, Image

from flexbe_core.ros.master import join, spin
from remodel_skills.abilities.ability import cell_abilities
from remodel_skills.belief_state import NO_CHANNEL
from remodel_skills.cell import Cell
from remodel_skills.device import Plant
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.robot_context import Observers
from remodel_skills.ros.owner import Clock, Owner
from remodel_skills.ros.servers import CellAbilityServer, Services
from remodel_states.core.tables import chosen_abilities
from remodel_states.edge.exported_tables import read_abilities, read_wire_materials
from remodel_vision.ros.image_message import FixedFrames, camera_info, image, optical_frame
from remodel_work.camera import Picture
from remodel_work.cell.cell_design import CellDesign
from remodel_work.errors import CellError
from remodel_work.panel import Panel, WireEnd
from remodel_work.ros.panel_message import read_panel


class Pictures:
    """Publishes every picture, and latched what was found in it."""

    def __init__(self, design: CellDesign, now: Callable[[], rospy.Time]) -> None:
        """Advertise the topics of the cameras that abilities use."""
        self._now = now
        self._raw, self._info, self._found = {}, {}, {}
        for camera in (*design.overhead_names, *(robot.camera.name for robot in design.robots)):
            topic = f"cell/{camera}"
            self._raw[camera] = rospy.Publisher(f"{topic}/image_raw", Image, queue_size=2)
            self._info[camera] = rospy.Publisher(f"{topic}/camera_info", CameraInfo, queue_size=2)
            self._found[camera] = rospy.Publisher(
                f"{topic}/detections", Image, queue_size=2, latch=True
            )

    def __call__(self, camera: str, picture: Picture, drawing: np.ndarray | None) -> None:
        """Publish a picture, or what was found in it."""
        frame, stamp = optical_frame(camera), self._now()
        if drawing is not None:
            self._found[camera].publish(image(drawing, frame, stamp))
            return
        self._raw[camera].publish(image(picture.rgb, frame, stamp))
        self._info[camera].publish(camera_info(picture.view, frame, stamp))


# The owner's thread computes without pause; rospy's threads get their turn this often [s].
SWITCH_INTERVAL_S = 0.001


@dataclass(frozen=True)
class OpenedPlant:
    """A plant that a node serves.

    Attributes:
        plant: what skills use.
        clock: its time.
        kind: "real" or "simulated", for people.
        offer: is called when the cell is built: what the plant publishes and offers by itself.
    """

    plant: Plant
    clock: Clock
    kind: str
    offer: Callable[[Owner, FixedFrames], None] = lambda owner, fixed: None


# Opens the plant of a cell that holds a panel. What it opens closes with the stack; it raises
# CellError, OSError or ValueError.
OpenPlant = Callable[[Panel, "CellMemory | None", ExitStack], OpenedPlant]


def main(open_plant: OpenPlant) -> int:
    """Serve a cell until ROS shuts down; returns the exit code."""
    join("cell")
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    with ExitStack() as closing:
        try:
            rows, abilities = read_abilities(), cell_abilities()
            served = chosen_abilities(
                list(abilities), rospy.get_param("~abilities", ""), rospy.get_param("~except", "")
            )
            materials = read_wire_materials()
            panel = read_panel(Path(rospy.get_param("~panel")), materials)
            memory = _memory(closing)
            opened = open_plant(panel, memory, closing)
            owner = _build(opened, panel, memory, closing)
        except (CellError, OSError, ValueError, yaml.YAMLError, MessageException) as error:
            rospy.logfatal("the cell does not start: %s", error)
            return 1
        rospy.set_param("~cell_kind", opened.kind)
        for name in served:
            CellAbilityServer(rows[name], abilities[name], owner)
        Services(owner, materials)
        own = [f"{each.name} ({each.file})" for each in read_parameters().table if each.is_own]
        if own:
            rospy.loginfo("numbers of the skills that are replaced: %s", ", ".join(own))
        rospy.loginfo("the cell is ready")
        return spin(owner.spin)


def _build(
    opened: OpenedPlant, panel: Panel, memory: CellMemory | None, closing: ExitStack
) -> Owner:
    clock, design = opened.clock, opened.plant.design
    fixed = FixedFrames(lambda: clock.now)
    observers = Observers(Pictures(design, lambda: clock.now), fixed)
    cell = Cell(opened.plant, observers=observers, memory=memory)
    closing.callback(cell.close)
    wire_id = str(rospy.get_param("~feed", ""))
    if wire_id and wire_id not in cell.plant.parked:
        channel_id = NO_CHANNEL
        if design.magazine is None:
            mouth = panel.panel_from_socket(*panel.wire(wire_id).goes_to(WireEnd.A)).position
            channel_id = panel.channel_in_front_of(mouth).id
        cell.feed(wire_id, channel_id)
    owner = Owner(cell, clock)
    opened.offer(owner, fixed)
    return owner


def _memory(closing: ExitStack) -> CellMemory | None:
    """Return what the cell keeps of its world; None if it keeps nothing."""
    folder = str(rospy.get_param("~memory", ""))
    if folder and not Path(folder).is_absolute():
        raise ValueError(f"memory is {folder!r}; name an absolute path, such as $PWD/{folder}")
    if not folder:
        return None
    memory = CellMemory(Path(folder))
    closing.callback(memory.close)
    return memory
