"""Formboards for tests: a wire over a row of clips, a duct, and wires in the forks of a harness."""

import math

import numpy as np
from panels import component, example, wire

from remodel_work.fixtures import WALL_M
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, Channel, Duct, Panel, PanelClip

LINE_X = -0.040
FIRST_Y = -0.085
STEP_M = 0.055
HEIGHT_M = 0.010
RETENTION_N = 5.0
HARNESS = example("harness")
FORK = HARNESS.ducts[1]  # F2, the one in the middle


def formboard(clips=6, ducts=()):
    """Return a panel with a row of clips along y, beside where the wire is fed."""
    places = [(LINE_X, FIRST_Y + STEP_M * i, math.pi / 2) for i in range(clips)]
    return Panel(
        name="formboard",
        size=(0.40, 0.80, 0.003),
        components=(
            component("X1", 1, -0.100, -0.20, side=1),
            component("X2", 2, 0.100, 0.20, side=-1),
        ),
        channels=(Channel(id="A", x=0.0, width=0.150, y_min=-0.35, y_max=0.35),),
        wires=(wire("W1", ("X1", "2"), ("X2", "2"), 0.62),),
        clips=tuple(
            PanelClip(
                id=f"C{i + 1}",
                pose=place,
                wire_diameter=0.003,
                height=HEIGHT_M,
                length=0.008,
                retention_force=RETENTION_N,
            )
            for i, place in enumerate(places)
        ),
        ducts=tuple(ducts),
    )


def along_clips(panel):
    """Return the path that passes all clips of a formboard, world frame."""
    ends = (FIRST_Y - 0.03, panel.clips[-1].pose[1] + 0.03)
    return tuple(BOARD @ Pose.level(LINE_X, y, 0.05, math.pi / 2) for y in ends)


def duct(x, y, length=0.12, width=0.050, yaw=math.pi / 2):
    """Return a duct along the channel."""
    return Duct(id="D1", pose=(x, y, yaw), length=length, width=width, height=0.020)


def touching(side, to):
    """Return how far aside of FORK's middle a wire touches a post from inside or outside [m].

    `side` is 1 or -1, `to` -1 inside and 1 outside.
    """
    face = FORK.width / 2 + (WALL_M if to > 0 else 0.0)
    return side * (face + to * (HARNESS.wires[0].radius + 0.0005))


def in_forks(wire_id, aside, height):
    """Return a wire of the harness, (n, 3) [m], world frame.

    It goes from opening to opening, and is bent aside to a height in FORK [m].
    """
    (ax, ay, z), (bx, by, _) = HARNESS.wire(wire_id).route
    share = np.linspace(0.0, 1.0, 40)
    bow = np.sin(np.pi * share) ** 2
    # In the fork the wire runs straight along the posts.
    x = ax + share * (bx - ax) + bow * (aside - (ax + bx) / 2) - np.sin(2 * np.pi * share) * ax / 2
    points = np.column_stack([x, ay + share * (by - ay), z + bow * (height - z)])
    return BOARD.apply(points)
