"""Who receives what abilities observe and intend."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_skills.belief_state import BeliefState
from remodel_skills.device import Device
from remodel_work.camera import Picture, View, best_view, overhead_name
from remodel_work.geometry import Array, Pose

Image = npt.NDArray[np.uint8]
# Called after every observation: camera, picture, and what was found drawn into it (None before it
# is known).
OnObservation = Callable[[str, Picture, Image | None], None]

# Called with poses in the world, by the names of their frames, that a goal asks to be shown.
OnFrames = Callable[[Mapping[str, Pose]], None]


@dataclass(frozen=True)
class Observers:
    """Callbacks that receive what abilities observe and intend; they change nothing.

    Attributes:
        on_observation: called after every observation.
        on_frames: called with the poses that a goal asks to show.
    """

    on_observation: OnObservation | None = None
    on_frames: OnFrames | None = None

    def show_frames(self, frames: Mapping[str, Pose]) -> None:
        """Show poses in the world, by the names of their frames."""
        if self.on_frames is not None:
            self.on_frames(frames)


class Cameras:
    """The cameras of one robot; the observers receive every picture."""

    def __init__(
        self, device: Device, wrist: str, belief: BeliefState, observers: Observers
    ) -> None:
        """Take pictures by a device, whose wrist camera has a name."""
        self._device, self._wrist = device, wrist
        self._belief, self._observers = belief, observers

    def overhead_view(self, points: Array) -> View:
        """Return where the overhead camera is that shows points (n, 3) [m] best."""
        return self._device.overhead_cameras[self._best(points)].view

    @property
    def wrist_view(self) -> View:
        """Where the wrist camera is, by the arm's own measure."""
        return self._device.wrist_camera.view

    def take_overhead_picture(self, points: Array) -> Picture:
        """Take a colour and depth picture by the camera that shows points (n, 3) [m] best.

        Before the live wire is touched, each of the others takes one, too, for comparisons later.
        """
        best = self._best(points)
        belief = self._belief
        if belief.feed is not None and not belief.is_touched:
            for number, camera in enumerate(self._device.overhead_cameras):
                if number != best and belief.board_before(camera.view) is None:
                    self._take_from_above(number)
        return self._take_from_above(best)

    def take_overhead_pictures(self, points: Array | None = None) -> tuple[Picture, ...]:
        """Take pictures by those cameras that each show one of points (n, 3) [m] best.

        None: by all of them, which together show the whole plate.
        """
        numbers = set(range(len(self._device.overhead_cameras)))
        if points is not None:
            numbers = {self._best(point[None]) for point in points}
        return tuple(self._take_from_above(number) for number in sorted(numbers))

    def _best(self, points: Array) -> int:
        return best_view([camera.view for camera in self._device.overhead_cameras], points)

    def _take_from_above(self, number: int) -> Picture:
        picture = self._device.overhead_cameras[number].take()
        self._belief.note_board(picture)
        return self._observed(overhead_name(number), picture)

    def take_wrist_picture(self) -> Picture:
        """Take a picture from the hand, with depth if its camera measures it."""
        return self._observed(self._wrist, self._device.wrist_camera.take())

    def _observed(self, camera: str, picture: Picture) -> Picture:
        if self._observers.on_observation is not None:
            self._observers.on_observation(camera, picture, None)
        return picture

    def show(self, camera: str, picture: Picture, drawing: Image) -> None:
        """Show what was found in a picture of a camera, "overhead" or "wrist": this robot's.

        Of several overhead cameras people see one picture after the other at the same place.
        """
        if self._observers.on_observation is not None:
            name = self._wrist if camera == "wrist" else camera
            self._observers.on_observation(name, picture, drawing)
