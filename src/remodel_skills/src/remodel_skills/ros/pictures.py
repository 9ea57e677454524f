"""Publishes what abilities see."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, Image

from remodel_vision.ros.image_message import camera_info, image, optical_frame
from remodel_work.camera import Picture
from remodel_work.cell.cell_design import CellDesign


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
