"""Names of a run's picture files: what they show, when [s] ROS time, and which camera saw it."""

from __future__ import annotations

import re

_NAME = re.compile(r".*_(?P<stamp>\d+\.\d{3})_(?P<camera>[a-z]+)\.jpg")


def picture_name(label: str, stamp_s: float, camera: str) -> str:
    """Return a file name."""
    return f"{label}_{stamp_s:.3f}_{camera}.jpg"


def seen_by(name: str) -> tuple[str, float]:
    """Return the camera and the time [s] of a picture, by its file's name.

    Raises:
        ValueError: if it is no such name.
    """
    found = _NAME.fullmatch(name)
    if found is None:
        raise ValueError(f"{name!r} is no name of a run's picture")
    return found["camera"], float(found["stamp"])
