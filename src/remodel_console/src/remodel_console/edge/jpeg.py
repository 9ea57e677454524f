"""Pictures as JPEG."""

from __future__ import annotations

import cv2
import numpy as np

from remodel_console.errors import PictureError

_LONGEST = 960  # [pixels] of the longer side; a page shows no more
_QUALITY = 80
_CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1}


def as_jpeg(data: bytes, height: int, width: int, step: int, encoding: str) -> bytes:
    """Return a picture as JPEG, no larger than pages show it.

    Args:
        data: rows of pixels, each `step` bytes.
        height: rows.
        width: pixels in a row.
        step: bytes in a row.
        encoding: rgb8, bgr8 or mono8, as in sensor_msgs/Image.

    Raises:
        PictureError: if it is no such picture.
    """
    channels = _CHANNELS.get(encoding)
    if channels is None:
        raise PictureError(f"pictures are {', '.join(_CHANNELS)}; this one is {encoding!r}")
    if step < width * channels or len(data) != height * step or not height * width:
        raise PictureError(f"{len(data)} bytes are no picture of {width} x {height} {encoding}")
    rows = np.frombuffer(data, np.uint8).reshape(height, step)[:, : width * channels]
    pixels = rows.reshape(height, width, channels)
    if encoding == "rgb8":
        pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    scale = _LONGEST / max(height, width)
    if scale < 1:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    _, encoded = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return bytes(encoded)
