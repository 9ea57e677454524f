"""Pictures and frames as messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image
from tf2_ros import StaticTransformBroadcaster

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
