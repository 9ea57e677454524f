"""What of a picture is cable, and what is known of it before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from remodel_vision.cables.lines import limited, median
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

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


# The table is sampled at every sixth pixel, and its median taken over this many samples: a third
# of a picture of 320 columns.
TABLE_STEP = 6
TABLE_WINDOW = 17
# How much the table varies is learned from every so many pixels each way.
SPARSE = 9
# Colours are this many standard deviations from the table's, and as if
# the table varied by 2.5 grey levels at least.
DEVIATIONS = 4.5
FLOOR_SQUARED = 2.5**2 * np.eye(3, dtype=np.float32)
# The darkest shadow, as a share of the table's light.
DARKEST_SHADOW = 0.6
# A cable is at most this thick, in half widths of the thin things in the picture.
THICK_HALF_WIDTHS = 2.3
THICK_AREA_HALF_WIDTHS = 30.0
# What is dim and lies beside a cable is its shadow; a dim strip of its own is a dark cable: in a
# window of so many pixels, less than this share of it, a fraction, is no shadow.
CORE_WINDOW = 15
CORE_SHARE = (2, 5)
# Sums the channels of a picture.
SUM = np.ones((1, 3), np.float32)


@dataclass(frozen=True, eq=False)
class Foreground:
    """What does not look like the table.

    Attributes:
        mask: (height, width), 1 where a cable is seen.
        reach: (height, width), each pixel's distance to what is no cable [px].
        foreign_objects: (height, width), 1 on and around objects too thick for a cable.
        half_width: of the cables, roughly [px].
        spread: standard deviation of the table's colours, the greatest direction [grey levels].
        covered: (height, width) distance from the table's colours [standard deviations].
        distance: the same, or that from a foreign object's colours on it.
    """

    mask: Pixels
    reach: Pixels
    foreign_objects: Pixels
    half_width: float
    spread: float
    covered: Pixels
    distance: Pixels


def find_foreground(rgb: Pixels, prior: Prior) -> Foreground:
    """Separate cables from the table in a picture (height, width, 3) of some 320 columns."""
    pixels = rgb.astype(np.float32)
    if prior.background is None:
        table = _median_of_every(rgb, TABLE_STEP, TABLE_WINDOW)
    else:
        table = prior.background.astype(np.float32)
    allowed = prior.allowed(rgb)
    whiten, spread = whitening(pixels[1::SPARSE, 1::SPARSE] - table[1::SPARSE, 1::SPARSE])
    covered = distance_from(pixels, table, whiten)
    lit = unlike_any_shade(pixels, table, whiten, covered)
    distance = covered
    things = _cables_without_shadows(distance, lit)
    mask = things if allowed is None else things & allowed
    reach = reach_in(mask)
    half_width = max(1.0, max(prior.widths) / 2) if prior.widths else typical_half_width(reach)
    thick = reach if allowed is None else reach_in(things)
    foreign_objects = foreign_objects_in(thick, half_width)
    if foreign_objects.any():
        near = median_nearby(rgb, half_width)
        other = distance_from(pixels, near, whiten)
        on_foreign_object = foreign_objects > 0
        distance = np.where(on_foreign_object, np.minimum(covered, other), covered)
        other_lit = unlike_any_shade(pixels, near, whiten, other)
        lit = np.where(on_foreign_object, lit & other_lit, lit)
        mask = _cables_without_shadows(distance, lit)
        mask[foreign_objects_in(reach_in(mask), half_width) > 0] = 0
        if allowed is not None:
            mask &= allowed
        reach = reach_in(mask)
    if allowed is not None:
        distance = np.where(allowed > 0, distance, 0.0)
    return Foreground(
        mask=mask,
        reach=reach,
        foreign_objects=foreign_objects,
        half_width=half_width,
        spread=spread,
        covered=covered,
        distance=distance,
    )


def _median_of_every(rgb: Pixels, step: int, window: int) -> Pixels:
    """Return the median around each pixel, over so many samples each way, `step` pixels apart."""
    height, width = rgb.shape[:2]
    samples = np.ascontiguousarray(rgb[step // 2 :: step, step // 2 :: step])
    median = cv2.medianBlur(samples, window).astype(np.float32)
    return cv2.resize(median, (width, height), interpolation=cv2.INTER_LINEAR)


def whitening(difference: Pixels) -> tuple[Array, float]:
    """Return the matrix (3, 3) that makes the table's variation round and 1, and its spread.

    Half of the pixels are trusted: those nearest to the table's colour, found in three rounds
    (the concentration steps of Rousseeuw's minimum covariance determinant).
    """
    samples = difference.reshape(-1, 3)
    white = samples
    for _ in range(3):
        near = np.einsum("ij,ij->i", white, white)
        trusted = samples[near <= median(near)]
        # Half of a three-dimensional normal distribution has 0.46 of its variance (chi-squared).
        spread = trusted.T @ trusted / (0.46 * len(trusted)) + FLOOR_SQUARED
        values, vectors = np.linalg.eigh(spread)
        whiten = (vectors / np.sqrt(values)).T
        white = samples @ whiten.T
    return whiten, float(np.sqrt(values[-1]))


def distance_from(pixels: Pixels, table: Pixels, whiten: Array) -> Pixels:
    """Return each pixel's distance from the table's colour [standard deviations]."""
    apart = cv2.transform(cv2.subtract(pixels, table), whiten)
    return cv2.sqrt(_dot(apart, apart))


def _dot(a: Pixels, b: Pixels) -> Pixels:
    """Return the products of the pixels of two pictures (height, width, 3)."""
    return cv2.transform(cv2.multiply(a, b), SUM)


def unlike_any_shade(pixels: Pixels, table: Pixels, whiten: Array, distance: Pixels) -> Pixels:
    """Return 1 where a pixel differs from the table's colour and from every shadow on it.

    Only what differs from the table's colour, by a `distance` (height, width), is compared.
    """
    unlike = above(distance)
    places = np.flatnonzero(unlike)
    seen, lit = pixels.reshape(-1, 3)[places], table.reshape(-1, 3)[places]
    along, square = np.einsum("ij,ij->i", seen, lit), np.einsum("ij,ij->i", lit, lit)
    shade = limited(along / (square + 1.0), DARKEST_SHADOW, 1.0)
    apart = (seen - shade[:, None] * lit) @ whiten.T.astype(np.float32)
    unlike.ravel()[places] = np.einsum("ij,ij->i", apart, apart) > DEVIATIONS**2
    return unlike


def above(distance: Pixels) -> Pixels:
    """Return 1 where a distance is that of something else."""
    return (distance > DEVIATIONS).astype(np.uint8)


def _cables_without_shadows(distance: Pixels, lit: Pixels) -> Pixels:
    """Return the pixels unlike the table and its shadows, and dim strips that are no shadow.

    Args:
        distance: from the table's colour [standard deviations].
        lit: 1 where a pixel is like no shadow either.
    """
    strong, weak = majority(lit), majority(above(distance))
    cores, whole = _count(strong, CORE_WINDOW), _count(weak, CORE_WINDOW)
    dark = (CORE_SHARE[1] * cores < CORE_SHARE[0] * whole).astype(np.uint8)
    return cv2.bitwise_or(strong, cv2.bitwise_and(weak, dark))


def majority(mask: Pixels) -> Pixels:
    """Return 1 where most of nine pixels are 1; a median, but faster."""
    return (_count(mask, 3) > 4).astype(np.uint8)


def _count(mask: Pixels, window: int) -> Pixels:
    """Return the number of ones in a window around each pixel."""
    return cv2.boxFilter(
        mask, cv2.CV_16U, (window, window), normalize=False, borderType=cv2.BORDER_REPLICATE
    )


def reach_in(mask: Pixels) -> Pixels:
    """Return the distance of each pixel of a mask of 0 and 1 to its border [px]."""
    return cv2.distanceTransform(mask, cv2.DIST_L2, 5)


def typical_half_width(reach: Pixels) -> float:
    """Return the median distance from a mask's ridge to its border [px]; 1 for an empty mask."""
    ridge = reach[(reach >= cv2.dilate(reach, np.ones((3, 3), np.uint8))) & (reach >= 1.0)]
    return max(1.0, median(ridge)) if len(ridge) else 1.0


def foreign_objects_in(reach: Pixels, half_width: float) -> Pixels:
    """Return what is too thick for a cable, with a rim as wide as a cable's half width."""
    limit = THICK_HALF_WIDTHS * half_width + 1
    cores = (reach > limit).astype(np.uint8)
    if not cores.any():
        return cores
    opened = (reach_in(1 - cores) <= limit + 1).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(opened, connectivity=8)
    big = stats[:, cv2.CC_STAT_AREA] > THICK_AREA_HALF_WIDTHS * half_width**2 + 40
    big[0] = False
    return big[labels].astype(np.uint8)


def median_nearby(rgb: Pixels, half_width: float) -> Pixels:
    """Return the median over a few cable widths: the colour of a foreign object below a cable."""
    return _median_of_every(rgb, 2, 2 * round(1.8 * half_width) + 3)
