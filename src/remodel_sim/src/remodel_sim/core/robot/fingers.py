"""The fingers that a hand carries, as data: what fits between neighbours, and what they hold.

The fingers close along the hand's y axis on a wire along its x axis. A tip with a notch holds a
wire without gripping it: the wire slides along between the two notches, and the lips below them
keep it from dropping out.
"""

from __future__ import annotations

from dataclasses import dataclass

# The body of the Panda's hand ends so far below the flange; fingers are measured from there [m].
HAND_BODY_M = 0.066
# Lengths are sums of decimal numbers of a file; a micrometre is far below what matters.
DIGITS = 6


@dataclass(frozen=True)
class Stem:
    """What carries a fingertip, from the hand down to it; lengths in metres.

    Attributes:
        width: along the wire.
        thickness: across it.
        behind: so far behind the pad's face.
    """

    width: float
    thickness: float
    behind: float


@dataclass(frozen=True)
class Notch:
    """A groove along the wire in a pad, level with the tool centre; lengths in metres.

    Attributes:
        depth: of the groove; its floor is the face that grips.
        height: of the groove.
    """

    depth: float
    height: float


@dataclass(frozen=True)
class Fingers:
    """Two equal fingers; lengths in metres.

    Attributes:
        name: of the type.
        length: from the hand's body to the tips.
        width: of a tip along the wire.
        thickness: of a tip across the wire, behind the face that grips.
        pad_height: of a tip.
        below: the tips reach so far below the tool centre.
        opening: between the pads when the hand is open.
        stem: above the tips.
        notch: in each pad; None: the pads are flat.
    """

    name: str
    length: float
    width: float
    thickness: float
    pad_height: float
    below: float
    opening: float
    stem: Stem
    notch: Notch | None = None

    @property
    def tip_m(self) -> float:
        """From the flange to the tips' lower edge [m]."""
        return round(HAND_BODY_M + self.length, DIGITS)

    @property
    def tool_m(self) -> float:
        """From the flange to the tool centre, the middle of a wire in the grip [m]."""
        return round(self.tip_m - self.below, DIGITS)

    @property
    def shut_m(self) -> float:
        """Between the faces that grip when the empty hand is closed: lips meet first [m]."""
        return 0.0 if self.notch is None else 2 * self.notch.depth

    @property
    def outer_m(self) -> float:
        """From the face that grips to the outer side of the thicker of tip and stem [m]."""
        return max(self.thickness, self.stem.behind + self.stem.thickness)


# The tips reach half the thickest wire below the tool centre: they grip a wire that lies on the
# plate.
PANDA_FINGERS = Fingers(
    name="panda_fingers",
    length=0.066,
    width=0.018,
    thickness=0.004,
    pad_height=0.014,
    below=0.003,
    opening=0.080,
    stem=Stem(width=0.012, thickness=0.008, behind=0.003),
)
