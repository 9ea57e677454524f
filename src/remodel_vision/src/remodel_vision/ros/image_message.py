"""Pictures and frames as messages, and the node cable_detector."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import rospy
from geometry_msgs.msg import Point, TransformStamped
from remodel_msgs.msg import ImageCable, ImageCables, ImageCrossing
from remodel_msgs.srv import DetectCables, DetectCablesRequest, DetectCablesResponse
from sensor_msgs.msg import CameraInfo, Image
from tf2_ros import StaticTransformBroadcaster

from flexbe_core.ros.master import join, spin
from remodel_vision.cables import Crossing, DetectedCable, Detection, detect_cables
from remodel_vision.cables.lines import sketch
from remodel_vision.colour import Pixels
from remodel_work.camera import View
from remodel_work.geometry import WORLD, Array, Pose


def optical_frame(camera: str) -> str:
    """Return the name of a camera's optical frame."""
    return f"{camera}_optical"


class FixedFrames:
    """Publishes frames that do not move, those of goals among them."""

    def __init__(self, now: Callable[[], rospy.Time]) -> None:
        """Advertise the topic."""
        self._now = now
        self._published: dict[str, TransformStamped] = {}
        self._broadcaster = StaticTransformBroadcaster()

    def __call__(self, frames: Mapping[str, Pose], parent: str = WORLD) -> None:
        """Publish frames in their parent, besides those published before."""
        for child, pose in frames.items():
            self._published[child] = transform(parent, child, pose, self._now())
        # Later subscribers get the last message only: it has all of them.
        self._broadcaster.sendTransform(list(self._published.values()))


def transform(parent: str, child: str, pose: Pose, stamp: rospy.Time) -> TransformStamped:
    """Return a frame in its parent as a message."""
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = (float(v) for v in pose.position)
    rotation.x, rotation.y, rotation.z, rotation.w = (float(v) for v in pose.quaternion)
    return message


CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1}
# Types of depth pictures, and what a unit of theirs is [m].
DEPTHS = {"32FC1": (np.float32, 1.0), "16UC1": (np.uint16, 1e-3)}


def image(rgb: np.ndarray, frame_id: str, stamp: rospy.Time) -> Image:
    """Return a colour picture (height, width, 3) uint8 as a message."""
    message = Image()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    message.height, message.width = rgb.shape[:2]
    message.encoding, message.step = "rgb8", 3 * rgb.shape[1]
    message.data = np.ascontiguousarray(rgb).tobytes()
    return message


def camera_info(view: View, frame_id: str, stamp: rospy.Time) -> CameraInfo:
    """Return a camera's intrinsics as a message."""
    lens = view.lens
    f, (cx, cy) = lens.focal_px, lens.centre_px
    message = CameraInfo()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    message.width, message.height = lens.width, lens.height
    message.distortion_model, message.D = "plumb_bob", [0.0] * 5
    message.K = [f, 0, cx, 0, f, cy, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0]
    return message


def read_image(message: Image) -> Pixels:
    """Return the colours (height, width, 3), RGB, of a message.

    Raises:
        ValueError: for another encoding, or data of another size than height times step.
    """
    channels = CHANNELS.get(message.encoding)
    if channels is None:
        raise ValueError(f"encoding {message.encoding!r}; it must be one of {', '.join(CHANNELS)}")
    row = channels * message.width
    if message.step < row or len(message.data) != message.height * message.step:
        raise ValueError(
            f"{len(message.data)} bytes in rows of {message.step}; {message.encoding} of "
            f"{message.width} x {message.height} px has rows of {row} bytes or more"
        )
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    pixels = rows[:, :row].reshape(message.height, message.width, channels)
    if message.encoding == "bgr8":
        pixels = pixels[..., ::-1]
    return np.ascontiguousarray(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))


def depth_image(depth: Array, frame_id: str, stamp: rospy.Time) -> Image:
    """Return depths (height, width) [m] as a message."""
    message = Image()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    message.height, message.width = depth.shape
    message.encoding, message.step = "32FC1", 4 * depth.shape[1]
    message.data = np.ascontiguousarray(depth, np.float32).tobytes()
    return message


def depth_of(message: Image) -> Array:
    """Return the depths (height, width) [m] of a message; not measured is NaN or 0.

    Raises:
        ValueError: for another encoding, or data of another size than height times step.
    """
    if message.encoding not in DEPTHS:
        raise ValueError(f"encoding {message.encoding!r}; it must be one of {', '.join(DEPTHS)}")
    kind, unit_m = DEPTHS[message.encoding]
    size = np.dtype(kind).itemsize
    if message.step != size * message.width or len(message.data) != message.height * message.step:
        raise ValueError(
            f"{len(message.data)} bytes in rows of {message.step}; {message.encoding} of "
            f"{message.width} x {message.height} px has rows of {size * message.width} bytes"
        )
    flat = np.frombuffer(message.data, np.dtype(kind).newbyteorder("><"[not message.is_bigendian]))
    return unit_m * flat.reshape(message.height, message.width).astype(np.float64)


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
