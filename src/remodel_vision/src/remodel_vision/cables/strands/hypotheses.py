"""Other foregrounds for cluttered pictures, where the table has no colour of its own.

A cable is thin and has one colour. So it differs from the median over a few of its widths, whatever
lies there; and once a piece of it is known, the rest is what has that piece's colour and is thin.
"""

from __future__ import annotations

import numpy as np

from remodel_vision.cables.strands.foreground import (
    DEVIATIONS,
    SPARSE,
    Foreground,
    Prior,
    above,
    distance_from,
    foreign_objects_in,
    majority,
    median_nearby,
    reach_in,
    typical_half_width,
    unlike_any_shade,
    whitening,
)
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# Half widths of the cables that are searched for by their difference from what lies around [px].
HALF_WIDTHS = (1.5, 3.5)
# A cable's colours vary by this much at least [grey levels], and along its shades by this share.
COLOUR_FLOOR, SHADE_SHARE = 6.0, 0.12
# A pixel is of a colour up to so many standard deviations from it.
OF_COLOUR = 3.0


def local_foreground(rgb: Pixels, half_width: float, first: Foreground, prior: Prior) -> Foreground:
    """Return what differs from the median over a few widths around it.

    Args:
        rgb: (height, width, 3), some 320 columns.
        half_width: of the cables, roughly [px].
        first: the foreground by the table's colour.
        prior: what is known.
    """
    pixels = rgb.astype(np.float32)
    near = median_nearby(rgb, half_width)
    whiten, spread = whitening(pixels[1::SPARSE, 1::SPARSE] - near[1::SPARSE, 1::SPARSE])
    distance = distance_from(pixels, near, whiten)
    mask = majority(unlike_any_shade(pixels, near, whiten, distance))
    return _thin_parts(mask, spread, distance, _allowed(rgb, first, prior), first)


def colour_foreground(rgb: Pixels, samples: Array, first: Foreground, prior: Prior) -> Foreground:
    """Return what has the colour of samples (n, 3) [grey levels] of a piece of cable."""
    mean = samples.mean(axis=0)
    apart = samples - mean
    shade = SHADE_SHARE * mean
    spread = apart.T @ apart / len(samples) + COLOUR_FLOOR**2 * np.eye(3) + np.outer(shade, shade)
    values, vectors = np.linalg.eigh(spread)
    whiten = ((vectors / np.sqrt(values)).T).astype(np.float32)
    pixels = rgb.astype(np.float32)
    away = distance_from(pixels, np.broadcast_to(mean.astype(np.float32), pixels.shape), whiten)
    mask = majority((away < OF_COLOUR).astype(np.uint8))
    covered = np.where((mask | first.mask) > 0, 2 * DEVIATIONS, 0.0).astype(np.float32)
    return _thin_parts(mask, first.spread, covered, _allowed(rgb, first, prior), first)


def _allowed(rgb: Pixels, first: Foreground, prior: Prior) -> Pixels | None:
    """Return 1 where a cable may be seen; with a known background, where that is covered."""
    allowed = prior.allowed(rgb)
    if prior.background is None:
        return allowed
    covered = above(first.covered)
    return covered if allowed is None else allowed & covered


def _thin_parts(
    mask: Pixels, spread: float, covered: Pixels, allowed: Pixels | None, first: Foreground
) -> Foreground:
    """Return the parts of a mask that are thin enough for a cable."""
    if allowed is not None:
        mask = mask & allowed
    reach = reach_in(mask)
    half_width = typical_half_width(reach)
    thick = foreign_objects_in(reach, half_width)
    if thick.any():
        mask = np.where(thick > 0, 0, mask).astype(np.uint8)
        reach = reach_in(mask)
    return Foreground(
        mask=mask,
        reach=reach,
        foreign_objects=first.foreign_objects,
        half_width=half_width,
        spread=spread,
        covered=covered,
        distance=np.where(mask > 0, 2 * DEVIATIONS, 0.0).astype(np.float32),
    )
