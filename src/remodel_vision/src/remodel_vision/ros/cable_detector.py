"""The node cable_detector: detect_cables for other nodes, by a service and on a topic."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import Point
from remodel_msgs.msg import ImageCable, ImageCables, ImageCrossing
from remodel_msgs.srv import DetectCables, DetectCablesRequest, DetectCablesResponse
from sensor_msgs.msg import Image

from flexbe_core.ros.master import join, spin
from remodel_vision.cables import Crossing, DetectedCable, Detection, detect_cables
from remodel_vision.cables.model import sketch
from remodel_vision.ros.image_message import image, read_image


class CableDetector:
    """Serves `~detect_cables`, and answers each image on `image` by `~cables` and `~picture`."""

    def __init__(self) -> None:
        """Advertise service and topics."""
        self._cables = rospy.Publisher("~cables", ImageCables, queue_size=1)
        self._picture = rospy.Publisher("~picture", Image, queue_size=1)
        rospy.Service("~detect_cables", DetectCables, answer)
        rospy.Subscriber("image", Image, self._detect, queue_size=1, buff_size=2**25)

    def _detect(self, message: Image) -> None:
        if not self._cables.get_num_connections() and not self._picture.get_num_connections():
            return
        try:
            rgb = read_image(message)
            found = detect_cables(rgb)
        except ValueError as error:
            topic = rospy.resolve_name("image")
            rospy.logwarn_throttle(10.0, f"an image on {topic} is not used: {error}")
            return
        self._cables.publish(_found(found, message))
        header = message.header
        self._picture.publish(image(sketch(rgb, found), header.frame_id, header.stamp))


def answer(request: DetectCablesRequest) -> DetectCablesResponse:
    """Return the cables in an image, or why it is not read."""
    mask, background = request.mask, request.background
    try:
        if len(request.colours) % 3:
            raise ValueError(
                f"{len(request.colours)} levels in `colours`; each colour has red, green and blue"
            )
        levels = np.frombuffer(bytes(request.colours), np.uint8).reshape(-1, 3)
        found = detect_cables(
            read_image(request.image),
            mask=read_image(mask).max(axis=2) if mask.data else None,
            colours=levels.tolist(),
            widths=list(request.widths),
            background=read_image(background) if background.data else None,
        )
    except ValueError as error:
        return DetectCablesResponse(False, str(error), ImageCables())
    return DetectCablesResponse(True, "", _found(found, request.image))


def _found(found: Detection, message: Image) -> ImageCables:
    return ImageCables(
        header=message.header,
        cables=[_cable(cable) for cable in found.cables],
        crossings=[_crossing(crossing) for crossing in found.crossings],
        warnings=list(found.warnings),
    )


def _cable(cable: DetectedCable) -> ImageCable:
    return ImageCable(
        centreline=[Point(x, y, 0.0) for x, y in cable.centreline.tolist()],
        tips=[Point(*tip.point.tolist(), 0.0) for tip in cable.tips],
        ends=[tip.end.value for tip in cable.tips],
        width=cable.width,
        colour=list(cable.colour),
        confidence=cable.confidence,
        warnings=list(cable.warnings),
    )


def _crossing(crossing: Crossing) -> ImageCrossing:
    return ImageCrossing(
        point=Point(*crossing.point.tolist(), 0.0),
        upper=crossing.upper,
        lower=crossing.lower,
        upper_at=crossing.upper_at,
        lower_at=crossing.lower_at,
        confidence=crossing.confidence,
    )


def main() -> int:
    """Serve until ROS shuts down; returns the exit code."""
    join("cable_detector")
    CableDetector()
    return spin()
