"""Cables in any picture: centrelines, tips, widths, crossings with who is on top."""

from remodel_vision.cables.detect import detect_cables
from remodel_vision.cables.lines import CableEnding, Crossing, DetectedCable, Detection, Spline, Tip

__all__ = [
    "CableEnding",
    "Crossing",
    "DetectedCable",
    "Detection",
    "Spline",
    "Tip",
    "detect_cables",
]
