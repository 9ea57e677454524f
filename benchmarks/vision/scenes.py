"""Random scenes by seed: smooth cables, which lie over each other, and what lies beside them.

A scene is kept when a person could read it: every loose tip lies clear of other strands, strands
cross at 20 degrees or more, crossings lie apart, and strands touch nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import cv2
import numpy as np
from renderer import Array, CableCurve, Image, Light, Picture, TrueCrossing, render

SIZE = (640, 480)  # (width, height) [px]
WIDTHS_PX = (5.0, 9.0)
# What is drawn by lot; "black" is asked for by name.
SURFACES = ("plain", "wood", "metal", "fabric")
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
RAIL = np.array([0.72, 0.73, 0.75], np.float32)
# Of curves: from the border [px]; the least sine of a crossing (20 degrees), and in widths the
# least radius of a bend, and the distances of tips, crossings and touching strands.
MARGIN_PX, MIN_CROSSING_SINE, MIN_BEND_WIDTHS = 14.0, 0.34, 3.0
TIP_CLEARANCE_WIDTHS, CROSSINGS_APART_WIDTHS = 2.5, 4.0
TOUCH_WIDTHS, CROSSING_REACH_WIDTHS = 1.25, 4.5
TRIES = 400

Random = np.random.Generator


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
    leaving: float = 0.2


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture (height, width, 3), RGB, and what it shows."""

    rgb: Picture
    cables: tuple[CableCurve, ...]
    crossings: tuple[TrueCrossing, ...]


def make_scene(kind: Kind, seed: int, **light: float) -> Scene:
    """Return the scene of a seed; `light` replaces fields of its Light."""
    random = np.random.default_rng([seed, kind.cables, kind.same_colour, kind.clutter])
    make = {"plain": _plain, "wood": _wood, "metal": _metal, "fabric": _fabric, "black": _black}
    surface = make[kind.surface or str(random.choice(SURFACES))](random)
    colours = _random_colours(random, surface, kind)
    cables, crossings = _random_cables(random, kind)
    for count, add in (
        (kind.sheets, _add_sheet),
        (kind.rails, _add_rail),
        (kind.clutter, _add_piece),
    ):
        for _ in range(count):
            add(random, surface)
    if kind.clutter + kind.sheets + kind.rails:
        colours = _seen_colours(random, surface, cables, kind)
    lit = replace(_random_light(random), **light)
    return Scene(render(surface, cables, crossings, colours, lit, random), cables, crossings)


def _random_light(random: Random) -> Light:
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


# Colours of cables


def _random_colours(random: Random, surface: Image, kind: Kind) -> Array:
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
    random: Random, surface: Image, cables: tuple[CableCurve, ...], kind: Kind
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


# Cables


def _random_cables(
    random: Random, kind: Kind
) -> tuple[tuple[CableCurve, ...], tuple[TrueCrossing, ...]]:
    """Return cables that a person could distinguish, and their crossings."""
    while True:
        cables: list[CableCurve] = []
        for _ in range(TRIES):
            leaves = bool(random.uniform() < kind.leaving)
            cable = _random_curve(random, random.uniform(*WIDTHS_PX), leaves=leaves)
            crossings = _readable_crossings([*cables, cable], random)
            if crossings is None:
                continue
            cables.append(cable)
            if len(cables) == kind.cables:
                return tuple(cables), crossings


def _random_curve(random: Random, width: float, *, leaves: bool) -> CableCurve:
    """Return a curve within the picture, which may begin outside of it."""
    limit = np.array(SIZE, float) - 1
    inner = MARGIN_PX + width
    while True:
        arc = np.arange(int(random.uniform(0.4, 1.0) * SIZE[0]), dtype=float)
        bend = np.zeros(len(arc))
        for _ in range(4):
            wave = random.uniform(120, 700)
            bend += random.normal(0, 0.006) * np.sin(2 * np.pi * (arc / wave + random.uniform()))
        sharpest = 1.0 / (MIN_BEND_WIDTHS * width)
        bend = np.clip(bend + random.normal(0, 0.002), -sharpest, sharpest)
        heading = random.uniform(0, 2 * np.pi) + np.cumsum(bend)
        points = np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
        if leaves:
            eighth = len(points) // 8
            points += _on_border(random, limit) - points[eighth]
            head, tail = points[: eighth - int(width)], points[eighth + 40 :]
            outside = np.all(np.any((head < -width) | (head > limit + width), axis=1)[:-20])
            if outside and np.all((tail > inner) & (tail < limit - inner)):
                return CableCurve(points, width)
        else:
            room = limit - 2 * inner - np.ptp(points, axis=0)
            if np.all(room > 0):
                points += inner + random.uniform(0, 1, 2) * room - points.min(axis=0)
                return CableCurve(points, width)


def _on_border(random: Random, limit: Array) -> Array:
    side = random.integers(4)
    place = random.uniform(0.15, 0.85, 2) * limit
    place[side % 2] = 0.0 if side < 2 else limit[side % 2]
    return place


def _readable_crossings(
    cables: list[CableCurve], random: Random
) -> tuple[TrueCrossing, ...] | None:
    """Return the crossings of cables, the upper strand drawn by lot; None if one is unreadable."""
    found: list[TrueCrossing] = []
    for a, b in combinations_with_replacement(range(len(cables)), 2):
        more = _pair_crossings(cables, a, b, random)
        if more is None:
            return None
        found += more
    widest = max(c.width for c in cables)
    places = np.array([c.point for c in found]).reshape(-1, 2)
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1) + 1e9 * np.eye(len(places))
    if len(found) > 1 and apart.min() < CROSSINGS_APART_WIDTHS * widest:
        return None
    tips = np.array([tip for c in cables for tip in (c.points[0], c.points[-1])])
    clear = np.linalg.norm(places[:, None] - tips[None], axis=-1)
    if np.any(clear < TIP_CLEARANCE_WIDTHS * widest * 1.5):
        return None
    return tuple(found)


def _pair_crossings(
    cables: list[CableCurve], a: int, b: int, random: Random
) -> list[TrueCrossing] | None:
    """Return the crossings of two cables, or of one with itself; None if one is unreadable."""
    p, q = cables[a].points, cables[b].points
    width = (cables[a].width + cables[b].width) / 2
    crossings = []
    for i, j, sine in _intersections(p, q):
        if a == b and j - i < 6 * width:
            continue
        if sine < MIN_CROSSING_SINE:
            return None
        ends = ((a, i), (b, j))
        up, low = ends if random.uniform() < 0.5 else ends[::-1]
        crossings.append(TrueCrossing(p[i], up[0], low[0], up[1], low[1]))
    places = [crossing.point for crossing in crossings]
    return crossings if _apart_elsewhere(p, q, a == b, width, places) else None


def _apart_elsewhere(p: Array, q: Array, same: bool, width: float, places: list[Array]) -> bool:
    """Return whether two strands touch only near their crossings, and tips nowhere."""
    i, j = np.arange(0, len(p), 3), np.arange(0, len(q), 3)
    gaps = np.linalg.norm(p[i][:, None] - q[j][None], axis=-1)
    if same:
        along = np.abs(i[:, None] - j[None])
        gaps = np.where(along < np.pi * MIN_BEND_WIDTHS * width, 1e9, gaps)
    tips = min(gaps[0].min(), gaps[-1].min(), gaps[:, 0].min(), gaps[:, -1].min())
    if tips < TIP_CLEARANCE_WIDTHS * width:
        return False
    touching = p[i][np.any(gaps < TOUCH_WIDTHS * width, axis=1)]
    if not len(touching) or not places:
        return not len(touching)
    reach = np.linalg.norm(touching[:, None] - np.array(places)[None], axis=-1).min(axis=1)
    return bool(np.all(reach < CROSSING_REACH_WIDTHS * width))


def _intersections(p: Array, q: Array) -> list[tuple[int, int, float]]:
    """Return the indices at which polylines (n, 2) and (m, 2) cross, with the sine of the angle."""
    u, v = np.diff(p, axis=0), np.diff(q, axis=0)
    base = q[None, :-1] - p[:-1, None]
    cross = u[:, None, 0] * v[None, :, 1] - u[:, None, 1] * v[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (base[..., 0] * v[None, :, 1] - base[..., 1] * v[None, :, 0]) / cross
        t = (base[..., 0] * u[:, None, 1] - base[..., 1] * u[:, None, 0]) / cross
    hits = np.argwhere((s >= 0) & (s < 1) & (t >= 0) & (t < 1))
    if p is q:
        hits = hits[hits[:, 1] > hits[:, 0] + 2]
    sines = [abs(cross[i, j]) / np.linalg.norm(u[i]) / np.linalg.norm(v[j]) for i, j in hits]
    return [(int(i), int(j), float(sine)) for (i, j), sine in zip(hits, sines, strict=True)]


# Table tops: plain, wood, brushed metal, fabric and black cloth, and what lies on them


def _noise(random: Random, size: tuple[int, int], cells: tuple[int, int]) -> Image:
    """Return noise (height, width) about 0 that varies over cells (across, down)."""
    small = random.normal(0, 1, (cells[1] + 1, cells[0] + 1)).astype(np.float32)
    return cv2.resize(small, size, interpolation=cv2.INTER_CUBIC)


def _tinted(base: Array, shade: Image) -> Image:
    return (base[None, None] * (1 + shade[..., None])).astype(np.float32)


def _plain(random: Random) -> Image:
    base = np.clip(random.uniform(0.2, 0.95) + random.uniform(-0.12, 0.12, 3), 0.05, 0.97)
    grain = 0.02 * _noise(random, SIZE, (SIZE[0] // 3, SIZE[1] // 3))
    return _tinted(base, grain + 0.03 * _noise(random, SIZE, (6, 5)))


def _wood(random: Random) -> Image:
    dark, light = np.array([0.35, 0.21, 0.10]), np.array([0.85, 0.68, 0.47])
    base = dark + random.uniform(0.1, 1.0) * (light - dark)
    turned = random.uniform() < 0.5
    shape = SIZE[::-1] if turned else SIZE
    across = np.linspace(0, random.uniform(4, 14), shape[1], dtype=np.float32)[:, None]
    warp = across + 0.6 * _noise(random, shape, (3, 4))
    rings = np.sin(2 * np.pi * warp) ** 3
    grain = _noise(random, shape, (12, shape[1] // 2))
    fine = _noise(random, shape, (shape[0] // 8, shape[1]))
    shade = 0.07 * rings + 0.06 * grain + 0.03 * fine + 0.05 * _noise(random, shape, (4, 3))
    shade = shade * np.float32(random.uniform(0.5, 1.3))
    return _tinted(base, shade.T if turned else shade)


def _metal(random: Random) -> Image:
    base = random.uniform(0.35, 0.8) * np.array([1.0, 1.0, 1.0]) + random.uniform(-0.02, 0.02, 3)
    turned = random.uniform() < 0.5
    shape = SIZE[::-1] if turned else SIZE
    brushed = _noise(random, shape, (10, shape[1]))
    shade = 0.04 * brushed + 0.10 * _noise(random, shape, (2, 1))
    return _tinted(base, shade.T if turned else shade)


def _fabric(random: Random) -> Image:
    base = np.clip(random.uniform(0.1, 0.7) + random.uniform(-0.1, 0.1, 3), 0.04, 0.9)
    period = random.uniform(2.5, 6.0)
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    weave = np.sin(2 * np.pi * x / period) * np.sin(2 * np.pi * y / period)
    shade = 0.10 * weave + 0.06 * _noise(random, SIZE, (SIZE[0] // 3, SIZE[1] // 3))
    return _tinted(base, (shade + 0.05 * _noise(random, SIZE, (5, 4))).astype(np.float32))


def _black(random: Random) -> Image:
    base = np.clip(random.uniform(0.0, 0.03) + random.uniform(-0.004, 0.004, 3), 0.0, 1.0)
    return _tinted(base, 0.3 * _noise(random, SIZE, (SIZE[0] // 2, SIZE[1] // 2)))


def _cover(surface: Image, inside: Array, colour: Array) -> None:
    """Lay a colour on a table top where `inside` (height, width, 1) is 1."""
    surface *= (1 - inside).astype(np.float32)
    surface += (inside * colour).astype(np.float32)


def _add_sheet(random: Random, surface: Image) -> None:
    """Lay a coloured sheet over a part of the picture from its border on."""
    turn = random.uniform(0, 2 * np.pi)
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    middle = np.array(SIZE) * random.uniform(0.3, 0.7, 2)
    away = (x - middle[0]) * np.cos(turn) + (y - middle[1]) * np.sin(turn)
    inside = np.clip(away - random.uniform(0.05, 0.25) * SIZE[0] + 0.5, 0, 1)[..., None]
    _cover(surface, inside, random.uniform(0.1, 0.95, 3))


def _add_rail(random: Random, surface: Image) -> None:
    """Lay a mounting rail across: a straight strip of metal, with bent edges."""
    turn = random.choice([0.0, np.pi / 2]) + random.normal(0, 0.03)
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    middle = np.array(SIZE) * random.uniform(0.15, 0.85, 2)
    away = (x - middle[0]) * np.sin(turn) + (y - middle[1]) * np.cos(turn)
    half = random.uniform(12, 24)
    inside = np.clip(half - np.abs(away) + 0.5, 0, 1)[..., None]
    bend = np.abs(np.abs(away) / half - 0.7) < 0.06
    shade = 1 + 0.15 * away / half - 0.3 * bend
    _cover(surface, inside, (RAIL * shade[..., None]).astype(np.float32))


def _add_piece(random: Random, surface: Image) -> None:
    """Lay a disc, a card or tape, in a colour of its own, with a soft shadow."""
    width, height = SIZE
    mask = np.zeros((height, width), np.uint8)
    centre = random.uniform(0, 1, 2) * SIZE
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
    dim = cv2.warpAffine(cv2.GaussianBlur(alpha[..., 0], (0, 0), 2.5), move, SIZE)
    surface *= 1 - 0.35 * dim[..., None]
    _cover(surface, alpha, random.uniform(0.05, 0.95, 3).astype(np.float32))
