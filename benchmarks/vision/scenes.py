"""Random scenes by seed, for the benchmark."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt
from renderer import Array, CableCurve, Light, Picture, TrueCrossing, random_cables, render

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
        surface: of the table; None draws one by lot.
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
        return self.clutter + self.sheets + self.rails > 0


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture (height, width, 3), RGB, and what it shows."""

    rgb: Picture
    cables: tuple[CableCurve, ...]
    crossings: tuple[TrueCrossing, ...]


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
    return Scene(render(surface, cables, crossings, colours, lit, random), cables, crossings)


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


# Table tops: plain, wood, brushed metal, fabric and black cloth, and what lies on them


Image = npt.NDArray[np.float32]

# What is drawn by lot; "black" is asked for by name.
SURFACES = ("plain", "wood", "metal", "fabric")
RAIL = np.array([0.72, 0.73, 0.75], np.float32)


def random_surface(random: np.random.Generator, size: tuple[int, int], kind: str) -> Image:
    """Return a table top (height, width, 3), RGB from 0 to 1, for a size (width, height).

    The kind is one of SURFACES or "black".
    """
    make = {"plain": _plain, "wood": _wood, "metal": _metal, "fabric": _fabric, "black": _black}
    return make[kind](random, size)


def smooth_noise(
    random: np.random.Generator, size: tuple[int, int], cells: tuple[int, int]
) -> Image:
    """Return noise (height, width) about 0 that varies over cells (across, down)."""
    small = random.normal(0, 1, (cells[1] + 1, cells[0] + 1)).astype(np.float32)
    return cv2.resize(small, size, interpolation=cv2.INTER_CUBIC)


def _tinted(base: npt.NDArray[np.float64], shade: Image) -> Image:
    return (base[None, None] * (1 + shade[..., None])).astype(np.float32)


def _plain(random: np.random.Generator, size: tuple[int, int]) -> Image:
    base = np.clip(random.uniform(0.2, 0.95) + random.uniform(-0.12, 0.12, 3), 0.05, 0.97)
    grain = 0.02 * smooth_noise(random, size, (size[0] // 3, size[1] // 3))
    return _tinted(base, grain + 0.03 * smooth_noise(random, size, (6, 5)))


def _wood(random: np.random.Generator, size: tuple[int, int]) -> Image:
    dark, light = np.array([0.35, 0.21, 0.10]), np.array([0.85, 0.68, 0.47])
    base = dark + random.uniform(0.1, 1.0) * (light - dark)
    turned = random.uniform() < 0.5
    shape = size[::-1] if turned else size
    across = np.linspace(0, random.uniform(4, 14), shape[1], dtype=np.float32)[:, None]
    warp = across + 0.6 * smooth_noise(random, shape, (3, 4))
    rings = np.sin(2 * np.pi * warp) ** 3
    grain = smooth_noise(random, shape, (12, shape[1] // 2))
    fine = smooth_noise(random, shape, (shape[0] // 8, shape[1]))
    shade = 0.07 * rings + 0.06 * grain + 0.03 * fine + 0.05 * smooth_noise(random, shape, (4, 3))
    shade = shade * np.float32(random.uniform(0.5, 1.3))
    return _tinted(base, shade.T if turned else shade)


def _metal(random: np.random.Generator, size: tuple[int, int]) -> Image:
    base = random.uniform(0.35, 0.8) * np.array([1.0, 1.0, 1.0]) + random.uniform(-0.02, 0.02, 3)
    turned = random.uniform() < 0.5
    shape = size[::-1] if turned else size
    brushed = smooth_noise(random, shape, (10, shape[1]))
    sheen = smooth_noise(random, shape, (2, 1))
    shade = 0.04 * brushed + 0.10 * sheen
    return _tinted(base, shade.T if turned else shade)


def _fabric(random: np.random.Generator, size: tuple[int, int]) -> Image:
    base = np.clip(random.uniform(0.1, 0.7) + random.uniform(-0.1, 0.1, 3), 0.04, 0.9)
    period = random.uniform(2.5, 6.0)
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    weave = np.sin(2 * np.pi * x / period) * np.sin(2 * np.pi * y / period)
    shade = 0.10 * weave + 0.06 * smooth_noise(random, size, (size[0] // 3, size[1] // 3))
    return _tinted(base, (shade + 0.05 * smooth_noise(random, size, (5, 4))).astype(np.float32))


def _black(random: np.random.Generator, size: tuple[int, int]) -> Image:
    base = np.clip(random.uniform(0.0, 0.03) + random.uniform(-0.004, 0.004, 3), 0.0, 1.0)
    grain = 0.3 * smooth_noise(random, size, (size[0] // 2, size[1] // 2))
    return _tinted(base, grain)


def add_sheets(random: np.random.Generator, surface: Image, sheets: int) -> None:
    """Lay coloured sheets on a table top, each over a part of the picture from its border on."""
    height, width = surface.shape[:2]
    for _ in range(sheets):
        turn = random.uniform(0, 2 * np.pi)
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        middle = np.array([width, height]) * random.uniform(0.3, 0.7, 2)
        away = (x - middle[0]) * np.cos(turn) + (y - middle[1]) * np.sin(turn)
        inside = np.clip(away - random.uniform(0.05, 0.25) * width + 0.5, 0, 1)[..., None]
        colour = random.uniform(0.1, 0.95, 3)
        surface *= (1 - inside).astype(np.float32)
        surface += (inside * colour).astype(np.float32)


def add_rails(random: np.random.Generator, surface: Image, rails: int) -> None:
    """Lay mounting rails across a table top: straight strips of metal, with bent edges."""
    height, width = surface.shape[:2]
    for _ in range(rails):
        turn = random.choice([0.0, np.pi / 2]) + random.normal(0, 0.03)
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        middle = np.array([width, height]) * random.uniform(0.15, 0.85, 2)
        away = (x - middle[0]) * np.sin(turn) + (y - middle[1]) * np.cos(turn)
        half = random.uniform(12, 24)
        inside = np.clip(half - np.abs(away) + 0.5, 0, 1)[..., None]
        bend = np.abs(np.abs(away) / half - 0.7) < 0.06
        shade = 1 + 0.15 * away / half - 0.3 * bend
        metal = (RAIL * shade[..., None]).astype(np.float32)
        surface *= (1 - inside).astype(np.float32)
        surface += (inside * metal).astype(np.float32)


def add_clutter(random: np.random.Generator, surface: Image, pieces: int) -> None:
    """Lay discs, cards and tape on a table top, in colours of their own, with soft shadows."""
    height, width = surface.shape[:2]
    for _ in range(pieces):
        mask = np.zeros((height, width), np.uint8)
        centre = random.uniform(0, 1, 2) * [width, height]
        reach = random.uniform(0.03, 0.12) * width
        if random.uniform() < 0.4:
            middle = (int(centre[0]), int(centre[1]))
            cv2.circle(mask, middle, int(reach * 0.6), 255, -1, cv2.LINE_AA)
        else:
            turn = random.uniform(0, 2 * np.pi)
            half = reach * np.array([1.0, random.uniform(0.45, 1.0)])
            corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
            spin = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            cv2.fillPoly(mask, [np.int32(centre + corners @ spin)], 255, cv2.LINE_AA)
        alpha = (mask / 255.0).astype(np.float32)[..., None]
        fall = random.uniform(1, 4, 2)
        move = np.array([[1, 0, fall[0]], [0, 1, fall[1]]])
        dim = cv2.warpAffine(cv2.GaussianBlur(alpha[..., 0], (0, 0), 2.5), move, (width, height))
        surface *= 1 - 0.35 * dim[..., None]
        colour = random.uniform(0.05, 0.95, 3).astype(np.float32)
        surface *= 1 - alpha
        surface += alpha * colour
