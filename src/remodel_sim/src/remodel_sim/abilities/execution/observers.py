"""Who receives what abilities observe and intend."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_work.camera import Picture
from remodel_work.geometry import Pose

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
