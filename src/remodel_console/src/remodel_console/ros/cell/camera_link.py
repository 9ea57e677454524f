"""The cell's cameras as the console sees them: its own observations, and the view for people.

Overhead and wrist camera publish whenever the cell takes a picture. The scene is rendered on
request only: the console requests it while a page shows it, and leaves a working cell most of its
time.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable

import rospy
from remodel_msgs.srv import TakePicture, TakePictureRequest
from sensor_msgs.msg import Image

from remodel_console.edge.jpeg import as_jpeg
from remodel_console.errors import CommandError, PictureError
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service
from remodel_console.watched import Pictures

CAMERAS = ("overhead", "wrist")
SCENE = "scene"
_EVERY_S = 0.2  # between two pictures of one camera, at least
_SCENE_EVERY_S = 2.0
_POLL_S = 0.2
# Of the cell's time, at most so much goes into pictures for people.
_SHARE_AT_WORK, _SHARE_AT_REST = 0.1, 0.5


class CameraLink:
    """Subscribes to the cameras, and turns what they see into JPEG on threads of its own."""

    def __init__(
        self, pictures: Pictures, is_at_work: Callable[[], bool], end: threading.Event
    ) -> None:
        """Connect.

        Args:
            pictures: receive the pictures.
            is_at_work: returns whether the cell is working.
            end: until it is set, the scene is requested too.
        """
        self._pictures = pictures
        self._is_at_work = is_at_work
        self._end = end
        self._waiting: dict[str, Image] = {}
        self._has_new = threading.Event()
        for camera in CAMERAS:
            for topic in ("image_raw", "detections"):
                rospy.Subscriber(
                    f"{topics.CELL}/{camera}/{topic}",
                    Image,
                    self._take,
                    callback_args=camera,
                    queue_size=1,
                )
        threading.Thread(target=self._encode, name="cameras", daemon=True).start()
        threading.Thread(target=self._watch_scene, name="scene", daemon=True).start()

    def _take(self, message: Image, camera: str) -> None:
        self._waiting[camera] = message
        self._has_new.set()

    def _encode(self) -> None:
        """Encode the newest picture of each camera; older ones are skipped."""
        while not self._end.wait(_EVERY_S):
            if self._has_new.wait(_EVERY_S):
                self._has_new.clear()
                for camera in CAMERAS:
                    message = self._waiting.pop(camera, None)
                    if message is not None:
                        self._keep(camera, message)

    def _keep(self, camera: str, message: Image) -> None:
        try:
            shape = (message.height, message.width, message.step)
            self._pictures.take(camera, as_jpeg(message.data, *shape, message.encoding))
        except PictureError as error:
            rospy.logwarn_throttle(60, "camera %s: %s", camera, error)

    def _watch_scene(self) -> None:
        begin_s = took_s = 0.0
        while not self._end.wait(_POLL_S):
            share = _SHARE_AT_WORK if self._is_at_work() else _SHARE_AT_REST
            is_soon = time.monotonic() < begin_s + max(_SCENE_EVERY_S, took_s / share)
            if is_soon or not self._pictures.is_wanted:
                continue
            begin_s = time.monotonic()
            with contextlib.suppress(CommandError):  # no cell; the page says so
                answer = call_service(
                    f"{topics.CELL}/take_picture", TakePicture, TakePictureRequest(SCENE)
                )
                if answer.success:
                    self._keep(SCENE, answer.image)
            took_s = time.monotonic() - begin_s
