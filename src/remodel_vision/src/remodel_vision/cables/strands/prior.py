"""What is known about a picture before cables are searched for in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from remodel_vision.pixels import Pixels

# A lit tube of a colour shows as such shades of it.
SHADES = (0.3, 1.3)
# A pixel may be a cable of a colour when it is so near to a shade of it: at least [grey levels],
# and as a share of the colour's length.
TOLERANCE_LEVELS, TOLERANCE_SHARE = 40.0, 0.25
# A cable is of a known width when it differs by this share at most.
WIDTH_SHARE = 0.3


@dataclass(frozen=True, eq=False)
class Prior:
    """Prior knowledge; what is None or empty is not known.

    Attributes:
        mask: (height, width), not 0 where a cable may be seen.
        colours: RGB of the cables [0 to 255].
        widths: of the cables [px].
        background: (height, width, 3), RGB, the same view without cables.
    """

    mask: Pixels | None = None
    colours: tuple[tuple[float, float, float], ...] = ()
    widths: tuple[float, ...] = ()
    background: Pixels | None = None

    @property
    def is_specific(self) -> bool:
        """Whether colours and widths are known: what fits both is a cable that is searched for."""
        return bool(self.colours and self.widths)

    def smaller(self, scale: int) -> Prior:
        """Return the same for a picture made `scale` times smaller."""
        mask, background = self.mask, self.background
        if mask is not None:
            mask = (_shrunk((mask != 0).astype(np.float32), scale) > 0).astype(np.uint8)
        if background is not None:
            background = _shrunk(background, scale)
        widths = tuple(width / scale for width in self.widths)
        return replace(self, mask=mask, background=background, widths=widths)

    def allowed(self, rgb: Pixels) -> Pixels | None:
        """Return 1 where a cable may be seen in a picture (height, width, 3); None: everywhere."""
        allowed = self.mask
        if self.colours:
            pixels = rgb.astype(np.float32)
            like: Pixels = np.zeros(rgb.shape[:2], np.uint8)
            for colour in self.colours:
                like |= _like(pixels, np.array(colour, np.float32))
            # A highlight along a tube has no colour.
            like = cv2.morphologyEx(like, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
            allowed = like if allowed is None else allowed & like
        return allowed

    def fits(self, width: float) -> bool:
        """Return whether a cable of a width [px] may be one of those searched for."""
        return not self.widths or any(abs(width / w - 1) <= WIDTH_SHARE for w in self.widths)


def _shrunk(picture: Pixels, scale: int) -> Pixels:
    """Return a picture made `scale` times smaller."""
    return cv2.resize(picture, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)


def _like(pixels: Pixels, colour: Pixels) -> Pixels:
    """Return 1 where pixels (height, width, 3) are near a shade of a colour (3,)."""
    square = max(float(colour @ colour), 1.0)
    shade = np.clip(pixels @ colour / square, *SHADES)
    apart = np.linalg.norm(pixels - shade[..., None] * colour, axis=-1)
    near = max(TOLERANCE_LEVELS, TOLERANCE_SHARE * float(np.sqrt(square)))
    return np.asarray(apart < near, np.uint8)


def checked_prior(
    shape: tuple[int, ...],
    mask: Pixels | None,
    colours: Sequence[Sequence[float]],
    widths: Sequence[float],
    background: Pixels | None,
) -> Prior:
    """Return prior knowledge for a picture of a shape (height, width, 3).

    Raises:
        ValueError: for a mask or background of another size or type, or a colour or width out of
            range.
    """
    if mask is not None and mask.shape != shape[:2]:
        raise ValueError(f"a mask of shape {mask.shape}; it must be {shape[:2]}, as the picture is")
    if background is not None and (background.shape != shape or background.dtype != np.uint8):
        raise ValueError(
            f"a background of shape {background.shape} and type {background.dtype}; it must be "
            f"{shape} and uint8, as the picture is"
        )
    for colour in colours:
        if len(colour) != 3 or not all(0 <= level <= 255 for level in colour):
            raise ValueError(f"colour {tuple(colour)}; it must be red, green, blue from 0 to 255")
    for width in widths:
        if not 0 < width < max(shape):
            raise ValueError(f"width {width}; it must be above 0 and below {max(shape)} px")
    triples = tuple((float(r), float(g), float(b)) for r, g, b in colours)
    return Prior(mask, triples, tuple(float(width) for width in widths), background)
