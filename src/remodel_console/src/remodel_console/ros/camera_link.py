"""The cell's cameras as the console sees them: every look of its own, and the scene for people.

Overhead and wrist camera publish whenever the cell looks. The scene is rendered on request only,
so it is asked for while a page shows it, and so seldom that the cell has most of its time.
"""

from __future__ import annotations

import threading
import time

import rospy
from remodel_msgs.srv import TakePicture, TakePictureRequest
from sensor_msgs.msg import Image

from remodel_console.edge.jpeg import as_jpeg
from remodel_console.errors import CommandError, PictureError
from remodel_console.pictures import Pictures
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service

LOOKS = ("overhead", "wrist")
SCENE = "scene"
_EVERY_S = 0.2  # between two pictures of one camera, at least
_SCENE_EVERY_S = 2.0
_SCENE_SHARE = 0.1  # of the cell's time, at most, goes into pictures for people


class CameraLink:
    """Subscribes to the cameras, and turns what they see into JPEG on threads of its own."""

    def __init__(self, pictures: Pictures, end: threading.Event) -> None:
        """Connect; until the event is set the scene is looked at too."""
        self._pictures = pictures
        self._end = end
        self._waiting: dict[str, Image] = {}
        self._has_looked = threading.Event()
        for camera in LOOKS:
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
        self._has_looked.set()

    def _encode(self) -> None:
        """Encode the newest look of each camera; those between are not seen by anybody."""
        while not self._end.wait(_EVERY_S):
            if self._has_looked.wait(_EVERY_S):
                self._has_looked.clear()
                for camera in LOOKS:
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
        rest_s = _SCENE_EVERY_S
        while not self._end.wait(rest_s):
            rest_s = _SCENE_EVERY_S
            if not self._pictures.are_wanted:
                continue
            begin_s = time.monotonic()
            try:
                answer = call_service(
                    f"{topics.CELL}/take_picture", TakePicture, TakePictureRequest(SCENE)
                )
            except CommandError:
                continue  # no cell; the page says so
            if answer.success:
                self._keep(SCENE, answer.image)
            rest_s = max(rest_s, (time.monotonic() - begin_s) / _SCENE_SHARE)
