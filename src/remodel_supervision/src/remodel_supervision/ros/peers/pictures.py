"""Gather what cameras saw in a behavior, and write it into a run's folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import Image

from remodel_supervision.core.runs.entries import picture_name
from remodel_supervision.ros.peers.cell import Cell

CAMERAS = ("overhead", "wrist")
_JPEG_QUALITY = 85


@dataclass(frozen=True)
class Sight:
    """An annotated picture that an ability made."""

    camera: str
    stamp_s: float
    image: Image


class CellPictures:
    """The pictures of the behavior under way."""

    def __init__(self, cell: Cell, runs: Path) -> None:
        """Listen to what abilities publish.

        Args:
            cell: takes a picture at the end of each behavior.
            runs: folder of the runs' folders.
        """
        self._cell = cell
        self._runs = runs
        self._sights: list[Sight] = []
        for camera in CAMERAS:
            rospy.Subscriber(
                f"cell/{camera}/detections", Image, self._on_image, callback_args=camera
            )

    def begin(self) -> None:
        """Forget those of the behavior before."""
        self._sights = []

    def keep(self, run: int, label: str) -> tuple[str, ...]:
        """Write what abilities saw, and the cell as it is now; return the names of the files.

        Those that cannot be written, since the disk is full, are left out.
        """
        after = Sight("scene", rospy.get_time(), self._cell.picture("scene"))
        try:
            return keep_pictures(self._runs / str(run), label, (*self._sights, after))
        except OSError as error:
            rospy.logwarn("the pictures of %s are not kept: %s", label, error)
            return ()

    def _on_image(self, image: Image, camera: str) -> None:
        self._sights.append(Sight(camera, image.header.stamp.to_sec(), image))


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
