"""Pictures as messages."""

from __future__ import annotations

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, Image

from remodel_work.camera import View


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
