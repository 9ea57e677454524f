"""Find ArUco labels, and the upright component below each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from remodel_sim.core.camera import Picture, View
from remodel_sim.core.component_shape import label_corners
from remodel_sim.core.geometry import Array, Pose
from remodel_sim.core.panel import Component


@dataclass(frozen=True, eq=False)
class ComponentSighting:
    """A component as seen.

    Attributes:
        world_from_component: upright, standing on the plate.
        residual: RMS distance between the label's corners seen and those of the pose [m].
        corners: (4, 2) of the label's black square in the picture [px].
    """

    world_from_component: Pose
    residual: float
    corners: Array


def find_labels(picture: Picture) -> dict[int, Array]:
    """Return the corners (4, 2) [px] of every label in the picture by its id."""
    detector = cv2.aruco.ArucoDetector(
        cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_250), _parameters()
    )
    # Cells of 3 px are below what the detector samples well: double the picture first.
    grey = cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY)
    doubled = cv2.resize(grey, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    corners, ids, _ = detector.detectMarkers(doubled)
    if ids is None:
        return {}
    # Pixel centres: column u of the picture is column 2 u + 0.5 of the doubled one.
    return {
        int(marker): (square.reshape(4, 2).astype(np.float64) - 0.5) / 2
        for marker, square in zip(ids.ravel(), corners, strict=True)
    }


def _parameters() -> cv2.aruco.DetectorParameters:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.cornerRefinementWinSize = 4
    parameters.minMarkerPerimeterRate = 0.02
    # A label is square and its bits are clean: take no half-seen one for another.
    parameters.errorCorrectionRate = 0.3
    return parameters


def locate_component(component: Component, corners: Array, view: View) -> ComponentSighting:
    """Return the upright pose that fits the label's corners (4, 2) [px] best.

    A component stands on the plate, so its label's height is known: each corner's ray meets that
    plane in one point, and the pose is the planar rigid motion nearest to the four points
    (Procrustes).
    """
    model = label_corners(component)
    height = float(model[0, 2])
    seen = view.on_plane(corners, height)[:, :2]
    flat = model[:, :2]
    centre_seen, centre_model = seen.mean(axis=0), flat.mean(axis=0)
    a, b = flat - centre_model, seen - centre_seen
    cross = float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    yaw = math.atan2(cross, float(np.sum(a * b)))
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    x, y = centre_seen - turn @ centre_model
    fitted = flat @ turn.T + [x, y]
    residual = float(np.sqrt(np.mean(np.sum((fitted - seen) ** 2, axis=1))))
    return ComponentSighting(Pose.level(float(x), float(y), 0.0, yaw), residual, corners)
