"""The fingers that a hand carries, as data: what fits between neighbours, and what they hold.

The fingers close along the hand's y axis on a wire along its x axis. Seen along the wire:

    |  |      |  |   stems
    |  |__  __|  |   upper lips
    |  |      |  |   eyelet: leads a wire that slides
    |____|  |____|
      |  |  |  |     flat pads: grip a wire
      |__|  |__|
"""

from __future__ import annotations

from dataclasses import dataclass

# The body of the Panda's hand ends so far below the flange; fingers are measured from there [m].
HAND_BODY_M = 0.066
# Camera housing on the side of the hand; the lens looks straight down. Hand frame.
CAMERA_MOUNT = (0.0, 0.118, 0.045)
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
class Eyelet:
    """A notch along the wire in each pad, above where it grips; lengths in metres.

    Closed pads make it an eyelet: a wire slides along in it, and cannot leave it.

    Attributes:
        depth: of each notch.
        height: of the notch.
        above: its middle is so far above the tool centre.
        bevel: so high is the slope from its back down to the pad's face: a wire in the notch of an
            open finger slides off it when the finger rises.
    """

    depth: float
    height: float
    above: float
    bevel: float = 0.0


@dataclass(frozen=True)
class Fingers:
    """Two equal fingers; lengths in metres.

    Attributes:
        name: of the type.
        length: from the hand's body to the tips.
        width: of a tip along the wire.
        thickness: of a tip across the wire, behind the face that grips.
        pad_height: of a tip, from its lower edge up to where the stem stands behind the face.
        below: the tips reach so far below the tool centre.
        opening: between the pads when the hand is open.
        stem: above the tips.
        eyelet: above the part that grips; None: there is none.
    """

    name: str
    length: float
    width: float
    thickness: float
    pad_height: float
    below: float
    opening: float
    stem: Stem
    eyelet: Eyelet | None = None

    @property
    def tip_m(self) -> float:
        """From the flange to the tips' lower edge [m]."""
        return round(HAND_BODY_M + self.length, DIGITS)

    @property
    def tool_m(self) -> float:
        """From the flange to the tool centre, the middle of a wire in the grip [m]."""
        return round(self.tip_m - self.below, DIGITS)

    @property
    def outer_m(self) -> float:
        """From the face that grips to the outer side of what stands beside the wire [m].

        Above an eyelet the finger may be thicker: neighbours of the wire are lower.
        """
        if self.eyelet is not None:
            return self.thickness
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
