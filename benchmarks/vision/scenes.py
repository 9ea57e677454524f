"""Random scenes by seed, for the benchmark."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from cable_curves import Array, CableCurve, TrueCrossing, random_cables
from renderer import Light, Rendered, render
from surfaces import SURFACES, add_clutter, add_rails, add_sheets, random_surface

SIZE = (640, 480)
WIDTHS_PX = (5.0, 9.0)
LEAVING = 0.2
# Distances in CIE Lab, from the table, between cables of different colours, and from what lies
# under a cable.
FROM_TABLE, FROM_EACH_OTHER, FROM_WHAT_IS_UNDER = 38.0, 35.0, 30.0
INSULATION = np.array(
    [
        [0.80, 0.08, 0.08],
        [0.08, 0.20, 0.75],
        [0.92, 0.78, 0.08],
        [0.10, 0.55, 0.15],
        [0.90, 0.45, 0.05],
        [0.06, 0.06, 0.06],
        [0.92, 0.92, 0.90],
        [0.45, 0.12, 0.55],
        [0.42, 0.22, 0.10],
        [0.10, 0.60, 0.70],
        [0.90, 0.45, 0.60],
        [0.45, 0.46, 0.48],
    ]
)


@dataclass(frozen=True)
class Kind:
    """What a scene is to be like.

    Attributes:
        cables: how many.
        same_colour: whether all have one colour.
        surface: of the table, or the path of a photograph; None draws one by lot.
        clutter: pieces that lie about.
        sheets: coloured sheets that cover a part of the table.
        rails: mounting rails across the table.
        leaving: the share of cables that leave the picture.
    """

    cables: int
    same_colour: bool
    surface: str | None = None
    clutter: int = 0
    sheets: int = 0
    rails: int = 0
    leaving: float = LEAVING

    @property
    def cluttered(self) -> bool:
        """Whether the table has more than one colour."""
        return "." in (self.surface or "") or self.clutter + self.sheets + self.rails > 0


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture, what it shows, and how it was lit."""

    kind: Kind
    cables: tuple[CableCurve, ...]
    crossings: tuple[TrueCrossing, ...]
    rendered: Rendered
    light: Light


def make_scene(kind: Kind, seed: int, **light: float) -> Scene:
    """Return the scene of a seed; `light` replaces fields of its Light."""
    random = np.random.default_rng([seed, kind.cables, kind.same_colour, kind.clutter])
    surface_kind = kind.surface or str(random.choice(SURFACES))
    surface = random_surface(random, SIZE, surface_kind)
    colours = random_colours(random, surface, kind)
    cables, crossings = random_cables(random, SIZE, kind.cables, WIDTHS_PX, kind.leaving)
    add_sheets(random, surface, kind.sheets)
    add_rails(random, surface, kind.rails)
    add_clutter(random, surface, kind.clutter)
    if kind.cluttered:
        colours = _seen_colours(random, surface, cables, kind)
    lit = replace(random_light(random), **light)
    rendered = render(surface, cables, crossings, colours, lit, random)
    return Scene(kind, cables, crossings, rendered, lit)


def random_light(random: np.random.Generator) -> Light:
    """Return ordinary light: what a lamp over a table and a camera with exposure control give."""
    return Light(
        azimuth=random.uniform(0, 2 * np.pi),
        elevation=np.radians(random.uniform(50, 80)),
        ambient=random.uniform(0.35, 0.6),
        specular=random.uniform(0.0, 0.5),
        falloff=random.uniform(0.0, 0.3),
        shadow=random.uniform(0.2, 0.5),
        exposure=random.uniform(0.75, 1.1),
        blur=random.uniform(0.5, 0.9),
        noise=random.uniform(1.5, 4.0),
    )


def random_colours(random: np.random.Generator, surface: np.ndarray, kind: Kind) -> Array:
    """Return a colour (n, 3) for each cable that stands out from the table."""
    table = _lab(surface.reshape(-1, 3).mean(axis=0)[None])[0]
    palette = [c for c in INSULATION if np.linalg.norm(_lab(c[None])[0] - table) > FROM_TABLE]
    random.shuffle(palette)
    chosen: list[Array] = []
    for colour in palette:
        apart = [np.linalg.norm(_lab(colour[None])[0] - _lab(c[None])[0]) for c in chosen]
        if not apart or min(apart) > FROM_EACH_OTHER:
            chosen.append(colour)
    if kind.same_colour:
        chosen = chosen[:1]
    return np.array([chosen[i % len(chosen)] for i in range(kind.cables)])


def _seen_colours(
    random: np.random.Generator, surface: np.ndarray, cables: tuple[CableCurve, ...], kind: Kind
) -> Array:
    """Return a colour (n, 3) for each cable that stands out from what lies under it.

    It is the first of a random order that does along 95 % of the cable, else the one that does
    best.
    """
    table = cv2.cvtColor(np.clip(surface, 0, 1), cv2.COLOR_RGB2LAB)
    palette = random.permutation(INSULATION)
    chosen: list[Array] = []
    for cable in cables:
        columns, rows = np.rint(cable.points).astype(int).T
        seen = (columns >= 0) & (rows >= 0) & (columns < SIZE[0]) & (rows < SIZE[1])
        under = table[rows[seen], columns[seen]].astype(float)
        apart = np.linalg.norm(under[:, None] - _lab(palette), axis=2)
        least = np.quantile(apart, 0.05, axis=0)
        good = np.flatnonzero(least > FROM_WHAT_IS_UNDER)
        chosen.append(palette[good[0] if len(good) else np.argmax(least)])
    return np.array([chosen[0] if kind.same_colour else colour for colour in chosen])


def _lab(colours: Array) -> Array:
    return cv2.cvtColor(colours.astype(np.float32)[None], cv2.COLOR_RGB2LAB)[0].astype(float)
