"""A formboard for tests: a wire from a terminal over a row of clips, and a duct."""

import math

from panels import component, wire

from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, Channel, Duct, Panel, PanelClip

LINE_X = -0.040
FIRST_Y = -0.085
STEP_M = 0.055
HEIGHT_M = 0.010
RETENTION_N = 5.0


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
