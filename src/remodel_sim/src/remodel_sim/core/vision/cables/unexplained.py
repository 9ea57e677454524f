"""What the mask shows and the cables found do not explain: reasons to doubt an answer."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from remodel_sim.core.vision.cables.foreground import Foreground
from remodel_sim.core.vision.cables.model import Cable
from remodel_sim.core.vision.cables.pixels import Pixels

# Around a cable's width, shadow and blur explain so much more, to both sides together [widths],
# and [px of the mask].
RIM_WIDTHS, RIM_PX = 1.8, 3
# A rest counts from this area on [squared cable widths], where it is this far from the table's
# colour [standard deviations] and not at the rim of a thing.
REST = 4.0
CLEAR = 8.0
# A cable over a thing of another colour than the table is doubted from this share of it on, for a
# rim of the thing may be taken for a cable, and a cable of the thing's colour is not seen.
OVER_THING = 0.02


def unexplained(foreground: Foreground, cables: list[Cable], scale: int) -> Iterator[str]:
    """Yield what is odd about cables in a mask made `scale` times smaller than the picture."""
    left = (foreground.distance > CLEAR).astype(np.uint8) & foreground.mask
    left[cv2.dilate(foreground.things, np.ones((7, 7), np.uint8)) > 0] = 0
    for i, cable in enumerate(cables):
        line = (cable.centreline + 0.5) / scale - 0.5
        _wipe(left, line, cable.width / scale)
        columns, rows = np.rint(line).astype(int).T
        height, width = left.shape
        at = foreground.things[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
        if at.mean() > OVER_THING:
            yield f"cable {i} lies on a thing for {at.mean():.0%} of its length"
    if not cables:
        return
    typical = float(np.median([cable.width for cable in cables])) / scale
    count, _, stats, centres = cv2.connectedComponentsWithStats(left, connectivity=8)
    for label in range(1, count):
        if stats[label, cv2.CC_STAT_AREA] > REST * typical**2:
            column, row = (centres[label] + 0.5) * scale - 0.5
            yield f"what lies at ({column:.0f}, {row:.0f}) is part of no cable found"


def _wipe(mask: Pixels, line: Pixels, width: float) -> None:
    """Erase a centreline (n, 2) [px] with its surroundings, beyond its ends too."""
    start = line[0] + (line[0] - line[2]) / 2
    stop = line[-1] + (line[-1] - line[-3]) / 2
    fixed = np.rint(np.vstack([start, line, stop]) * 16).astype(np.int32)
    thickness = round(RIM_WIDTHS * width + RIM_PX)
    cv2.polylines(mask, [fixed], False, (0,), thickness, cv2.LINE_8, 4)
