"""Write what cameras saw into a run's folder."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from sensor_msgs.msg import Image

from remodel_planner.core.supervision.picture_name import picture_name
from remodel_planner.ros.task_supervisor import Sight

_JPEG_QUALITY = 85


def keep_pictures(folder: Path, label: str, sights: tuple[Sight, ...]) -> tuple[str, ...]:
    """Write pictures as JPEG files, and return their names.

    Args:
        folder: that they are written into.
        label: that their names begin with; time [s] and camera follow.
        sights: the pictures.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    for sight in sights:
        name = picture_name(label, sight.stamp_s, sight.camera)
        (folder / name).write_bytes(jpeg(sight.image))
        names.append(name)
    return tuple(names)


def jpeg(image: Image) -> bytes:
    """Return an rgb8 picture as JPEG."""
    pixels = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
    options = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    _, encoded = cv2.imencode(".jpg", cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), options)
    return bytes(encoded.tobytes())
