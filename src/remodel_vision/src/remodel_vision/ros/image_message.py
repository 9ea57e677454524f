"""Pictures as messages."""

from __future__ import annotations

import numpy as np
import rospy
from sensor_msgs.msg import Image


def image(rgb: np.ndarray, frame_id: str, stamp: rospy.Time) -> Image:
    """Return a colour picture (height, width, 3) uint8 as a message."""
    message = Image()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    message.height, message.width = rgb.shape[:2]
    message.encoding, message.step = "rgb8", 3 * rgb.shape[1]
    message.data = np.ascontiguousarray(rgb).tobytes()
    return message
