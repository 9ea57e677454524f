"""Read pictures that people took."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np

from remodel_vision.colour import Pixels

# ITU-T T.81, B.1.1: a marker is FF and a byte that is neither 0 nor the number of a restart.
JPEG_MARKER = re.compile(rb"\xff+([^\x00\xd0-\xd7\xff])", re.DOTALL)
START_OF_IMAGE, END_OF_IMAGE = b"\xff\xd8", 0xD9


class PictureFileError(Exception):
    """A file is no picture, or is truncated."""


def read_picture(file: Path) -> Pixels:
    """Return the picture in a file, (height, width, 3), RGB, as a viewer shows it.

    It is turned as its EXIF data say; grey pictures, palettes and 16 bits become RGB of 8 bits, and
    transparency is ignored.

    Raises:
        PictureFileError: when the file cannot be read, or ends too early.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise PictureFileError(f"{file} cannot be read: {error.strerror}") from error
    # OpenCV refuses parts of files of all other formats.
    if data.startswith(START_OF_IMAGE) and not _is_whole_jpeg(data):
        raise PictureFileError(f"{file} ends in the middle of its picture; copy it again")
    try:
        bgr = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        bgr = None
    if bgr is None:
        raise PictureFileError(
            f"{file} is no picture that OpenCV reads, or is damaged; give a whole PNG, JPEG, BMP, "
            "TIFF or WebP"
        )
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)


def _is_whole_jpeg(data: bytes) -> bool:
    """Return whether a JPEG picture reaches its end marker, past those of previews within it."""
    at = len(START_OF_IMAGE)
    while (marker := JPEG_MARKER.search(data, at)) is not None:
        if marker[1][0] == END_OF_IMAGE:
            return True
        at = marker.end() + int.from_bytes(data[marker.end() : marker.end() + 2], "big")
    return False
