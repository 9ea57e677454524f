"""Draw random cables as lit tubes on a table top, with the truth.

Independent of the cell's physics and renderer: strands are tubes with height, found per pixel from
the nearest point of the centreline and a z-buffer, at twice the resolution; light is ambient,
diffuse and specular, strands cast shadows on the table and on strands below; then lens blur,
exposure, noise and eight bits.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

FINE = 2  # sub-pixels per pixel and axis
CHUNK = 20  # points of a strand drawn at a time
RISE_WIDTHS = 2.5  # how far before a crossing the upper strand begins to rise

Picture = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Light:
    """Light and camera of a picture.

    Attributes:
        azimuth, elevation: of the light [rad].
        ambient: share of the light without direction.
        specular: strength of highlights.
        falloff: how much darker the far side of the picture is.
        shadow: how much of the light a shadow takes.
        exposure: factor.
        blur: standard deviation of the lens's blur [px].
        noise: standard deviation [grey levels].
        black: what the camera takes off all levels, so that dark ones are cut off [grey levels].
        motion: how far the camera moves while the shutter is open, along the light's azimuth [px].
        jpeg: quality of the JPEG, with chroma of half the resolution; 0 for none.
    """

    azimuth: float
    elevation: float
    ambient: float = 0.45
    specular: float = 0.35
    falloff: float = 0.15
    shadow: float = 0.45
    exposure: float = 1.0
    blur: float = 0.6
    noise: float = 3.0
    black: float = 0.0
    motion: float = 0.0
    jpeg: float = 0.0

    @property
    def direction(self) -> Array:
        """Towards the light, (3,): x right, y down in the picture, z to the camera."""
        flat = np.cos(self.elevation)
        return np.array(
            [flat * np.cos(self.azimuth), flat * np.sin(self.azimuth), np.sin(self.elevation)]
        )


def render(
    surface: npt.NDArray[np.float32],
    cables: tuple[CableCurve, ...],
    crossings: tuple[TrueCrossing, ...],
    colours: Array,
    light: Light,
    random: np.random.Generator,
) -> Picture:
    """Draw cables of colours (n, 3) on a table top (height, width, 3); return RGB."""
    height, width = surface.shape[:2]
    fine = cv2.resize(surface, (FINE * width, FINE * height), interpolation=cv2.INTER_CUBIC)
    lifts = [_lift(i, cables, crossings) for i in range(len(cables))]
    canvas = _Canvas(fine, light)
    for cable, lift in zip(cables, lifts, strict=True):
        canvas.cast(cable, lift)
    canvas.fall()
    for cable, lift, colour in zip(cables, lifts, colours, strict=True):
        canvas.draw(cable, lift, colour)
    sharp = cv2.resize(canvas.rgb, (width, height), interpolation=cv2.INTER_AREA)
    return _expose(sharp, light, random)


def _lift(index: int, cables: tuple[CableCurve, ...], crossings: tuple[TrueCrossing, ...]) -> Array:
    """Return the height of a cable's centreline over the table (n,) [px]."""
    cable = cables[index]
    arc = np.arange(len(cable.points), dtype=float)
    lift = np.full(len(arc), cable.width / 2)
    for crossing in crossings:
        if crossing.upper == index:
            rise = cables[crossing.lower].width * 1.02
            reach = RISE_WIDTHS * cable.width
            lift += rise * np.exp(-0.5 * ((arc - crossing.upper_index) / reach) ** 2)
    return lift


class _Canvas:
    """A picture in the making, at FINE times the resolution."""

    def __init__(self, surface: npt.NDArray[np.float32], light: Light) -> None:
        self.rgb = surface.copy()
        self._heights = np.zeros(surface.shape[:2], np.float32)
        self._dimmed = np.zeros(surface.shape[:2], np.float32)
        self._raised = np.zeros(surface.shape[:2], np.float32)
        self._light = light

    def cast(self, cable: CableCurve, lift: Array) -> None:
        """Add a cable's shadow: on the table, and of its raised parts on strands below."""
        direction = self._light.direction
        slope = -direction[:2] / direction[2]
        self._shade(self._dimmed, cable, cable.points + lift[:, None] * slope, lift > 0)
        over = lift - cable.width / 2
        below = cable.points + over[:, None] * slope
        self._shade(self._raised, cable, below, over > 0.6 * cable.width)

    def _shade(
        self,
        layer: npt.NDArray[np.float32],
        cable: CableCurve,
        points: Array,
        where: npt.NDArray[np.bool_],
    ) -> None:
        for run in np.split(np.arange(len(points)), np.flatnonzero(np.diff(where)) + 1):
            if where[run[0]] and len(run) > 1:
                fixed = np.int32(np.rint((points[run] * FINE + 0.5) * 16))
                thick = round(FINE * cable.width)
                cv2.polylines(layer, [fixed], False, 1.0, thick, cv2.LINE_8, 4)

    def fall(self) -> None:
        """Let the shadows fall, softened, and the light fade over the table."""
        self._dimmed = cv2.GaussianBlur(self._dimmed, (0, 0), FINE * 1.3)
        self._raised = cv2.GaussianBlur(self._raised, (0, 0), FINE * 0.8)
        self.rgb *= 1 - self._light.shadow * self._dimmed[..., None]

    def draw(self, cable: CableCurve, lift: Array, colour: Array) -> None:
        """Draw a cable as a tube."""
        points = cable.points * FINE + (FINE - 1) / 2
        for start in range(0, len(points) - 1, CHUNK):
            stop = min(start + CHUNK + 1, len(points))
            self._chunk(points[start:stop], lift[start:stop], cable.width, colour)

    def _chunk(self, points: Array, lift: Array, width: float, colour: Array) -> None:
        radius = FINE * width / 2
        high, wide = self._heights.shape
        x0, y0 = np.maximum(np.floor(points.min(axis=0) - radius - 1).astype(int), 0)
        x1, y1 = np.minimum(np.ceil(points.max(axis=0) + radius + 2).astype(int), [wide, high])
        if x1 <= x0 or y1 <= y0:
            return
        x, y = np.meshgrid(np.arange(x0, x1), np.arange(y0, y1))
        pixels = np.column_stack([x.ravel(), y.ravel()]).astype(float)
        offset, across, z = _nearest(pixels, points, lift)
        inside = offset <= radius
        rise = np.sqrt(np.clip(1 - (offset / radius) ** 2, 0, 1))
        top = z + rise * width / 2
        shape = x.shape
        window = (slice(y0, y1), slice(x0, x1))
        seen = (inside & (top > self._heights[window].ravel())).reshape(shape)
        tilt = np.minimum(offset / radius, 1)
        normal = np.column_stack([across * tilt[:, None], rise]).reshape(*shape, 3)
        tone = self._lit(normal, colour)
        low = (z < width * 0.9).reshape(shape)
        tone *= 1 - self._light.shadow * (self._raised[window] * low)[..., None]
        self.rgb[window][seen] = tone[seen]
        self._heights[window][seen] = top.reshape(shape)[seen]

    def _lit(self, normal: Array, colour: Array) -> Array:
        direction = self._light.direction
        half = direction + np.array([0.0, 0.0, 1.0])
        half /= np.linalg.norm(half)
        diffuse = np.clip(normal @ direction, 0, 1)
        shine = np.clip(normal @ half, 0, 1) ** 40
        level = self._light.ambient + (1 - self._light.ambient) * diffuse / direction[2]
        return colour * np.clip(level, 0, 1.4)[..., None] + self._light.specular * shine[..., None]


def _nearest(pixels: Array, points: Array, lift: Array) -> tuple[Array, Array, Array]:
    """Return each pixel's distance to a polyline, the unit vector from it, and its height there.

    Beyond the ends of the polyline the distance is infinite: strands are cut square.
    """
    start, way = points[:-1], np.diff(points, axis=0)
    share = np.einsum("nkd,kd->nk", pixels[:, None] - start, way) / np.sum(way**2, axis=1)
    clipped = np.clip(share, 0, 1)
    gap = pixels[:, None] - (start + clipped[..., None] * way)
    distance = np.linalg.norm(gap, axis=-1)
    best = np.argmin(distance, axis=1)
    rows = np.arange(len(pixels))
    beyond = (share[:, 0] < 0) & (best == 0) | (share[:, -1] > 1) & (best == len(way) - 1)
    offset = np.where(beyond, np.inf, distance[rows, best])
    across = gap[rows, best] / np.maximum(distance[rows, best], 1e-9)[:, None]
    z = lift[best] + clipped[rows, best] * (lift[best + 1] - lift[best])
    return offset, across, z


def _expose(sharp: npt.NDArray[np.float32], light: Light, random: np.random.Generator) -> Picture:
    height, width = sharp.shape[:2]
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, width), np.linspace(-0.5, 0.5, height))
    fade = 1 + light.falloff * (x * np.cos(light.azimuth) + y * np.sin(light.azimuth))
    lens = cv2.GaussianBlur(sharp, (0, 0), light.blur)
    if light.motion:
        lens = cv2.filter2D(lens, -1, _streak(light.motion, light.azimuth))
    levels = 255 * light.exposure * lens * fade[..., None].astype(np.float32) - light.black
    noisy = levels + random.normal(0, light.noise, levels.shape)
    rgb = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return _compressed(rgb, int(light.jpeg)) if light.jpeg else rgb


def _streak(length: float, azimuth: float) -> npt.NDArray[np.float32]:
    """Return the kernel of a motion over a length [px] in a direction [rad]."""
    half = int(np.ceil(length / 2)) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    way = length / 2 * np.array([np.cos(azimuth), np.sin(azimuth)])
    ends = np.rint((np.stack([half - way, half + way])) * 16).astype(int)
    cv2.line(kernel, ends[0].tolist(), ends[1].tolist(), (1.0,), 1, cv2.LINE_AA, 4)
    return kernel / kernel.sum()


def _compressed(rgb: Picture, quality: int) -> Picture:
    """Return a picture as it comes out of a JPEG with 4:2:0 chroma, as cameras write it."""
    options = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
    ]
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), options)
    return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


# Random cables on a table: smooth curves, and which strand lies on top where two cross.
#
# A scene is kept when a person could read it: every loose tip lies clear of other strands, strands
# cross at 20 degrees or more, crossings lie apart, and strands touch nowhere else.


Array = npt.NDArray[np.float64]

STEP_PX = 1.0
MARGIN_PX = 14.0
MIN_CROSSING_SINE = 0.34  # 20 degrees
MIN_BEND_WIDTHS = 3.0  # the least radius of a bend
TIP_CLEARANCE_WIDTHS = 2.5
CROSSINGS_APART_WIDTHS = 4.0
TOUCH_WIDTHS = 1.25
CROSSING_REACH_WIDTHS = 4.5
TRIES = 400


@dataclass(frozen=True, eq=False)
class CableCurve:
    """A cable's true shape.

    Attributes:
        points: (n, 2) centreline in steps of 1 px [px]; it may leave the picture.
        width: [px].
    """

    points: Array
    width: float


@dataclass(frozen=True, eq=False)
class TrueCrossing:
    """Where one strand lies on another.

    Attributes:
        point: (2,) [px].
        upper, lower: indices of the cables.
        upper_index, lower_index: of the nearest points on them.
    """

    point: Array
    upper: int
    lower: int
    upper_index: int
    lower_index: int


def random_curve(
    random: np.random.Generator, size: tuple[int, int], width: float, *, leaves: bool
) -> CableCurve:
    """Return a curve within a picture of size (width, height) that may begin outside of it."""
    limit = np.array(size, float) - 1
    while True:
        count = int(random.uniform(0.4, 1.0) * size[0] / STEP_PX)
        arc = np.arange(count) * STEP_PX
        bend = np.zeros(count)
        for _ in range(4):
            wave = random.uniform(120, 700)
            bend += random.normal(0, 0.006) * np.sin(2 * np.pi * (arc / wave + random.uniform()))
        sharpest = 1.0 / (MIN_BEND_WIDTHS * width)
        bend = np.clip(bend + random.normal(0, 0.002), -sharpest, sharpest)
        heading = random.uniform(0, 2 * np.pi) + np.cumsum(bend) * STEP_PX
        points = np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]) * STEP_PX, axis=0)
        inner = MARGIN_PX + width
        if leaves:
            points += _on_border(random, limit) - points[len(points) // 8]
            head = points[: len(points) // 8 - int(width)]
            outside = np.all(np.any((head < -width) | (head > limit + width), axis=1)[:-20])
            tail = points[len(points) // 8 + 40 :]
            if outside and np.all((tail > inner) & (tail < limit - inner)):
                return CableCurve(points, width)
        else:
            span = np.ptp(points, axis=0)
            room = limit - 2 * inner - span
            if np.all(room > 0):
                points += inner + random.uniform(0, 1, 2) * room - points.min(axis=0)
                return CableCurve(points, width)


def _on_border(random: np.random.Generator, limit: Array) -> Array:
    side = random.integers(4)
    place = random.uniform(0.15, 0.85, 2) * limit
    place[side % 2] = 0.0 if side < 2 else limit[side % 2]
    return place


def random_cables(
    random: np.random.Generator,
    size: tuple[int, int],
    count: int,
    widths: tuple[float, float],
    leaving: float,
) -> tuple[tuple[CableCurve, ...], tuple[TrueCrossing, ...]]:
    """Return cables that a person could distinguish, and their crossings.

    Args:
        random: the source of chance.
        size: (width, height) of the picture [px].
        count: of cables.
        widths: the least and the greatest [px].
        leaving: share of the cables that leave the picture.
    """
    while True:
        cables: list[CableCurve] = []
        for _ in range(TRIES):
            leaves = bool(random.uniform() < leaving)
            cable = random_curve(random, size, random.uniform(*widths), leaves=leaves)
            crossings = readable_crossings([*cables, cable], random)
            if crossings is None:
                continue
            cables.append(cable)
            if len(cables) == count:
                return tuple(cables), crossings


def readable_crossings(
    cables: list[CableCurve], random: np.random.Generator
) -> tuple[TrueCrossing, ...] | None:
    """Return the crossings of cables, the upper strand drawn by lot; None if one is unreadable."""
    found: list[TrueCrossing] = []
    for a in range(len(cables)):
        for b in range(a, len(cables)):
            more = _pair_crossings(cables, a, b, random)
            if more is None:
                return None
            found += more
    widest = max(c.width for c in cables)
    places = np.array([c.point for c in found]).reshape(-1, 2)
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1) + 1e9 * np.eye(len(places))
    if len(found) > 1 and apart.min() < CROSSINGS_APART_WIDTHS * widest:
        return None
    for cable in cables:
        for tip in (cable.points[0], cable.points[-1]):
            near = np.linalg.norm(places - tip, axis=1) < TIP_CLEARANCE_WIDTHS * widest * 1.5
            if near.any():
                return None
    return tuple(found)


def _pair_crossings(
    cables: list[CableCurve], a: int, b: int, random: np.random.Generator
) -> list[TrueCrossing] | None:
    p, q = cables[a].points, cables[b].points
    mean_width = (cables[a].width + cables[b].width) / 2
    crossings = []
    places = []
    for i, j, sine in intersections(p, q):
        if a == b and j - i < 6 * mean_width:
            continue
        if sine < MIN_CROSSING_SINE:
            return None
        first_up = bool(random.uniform() < 0.5)
        places.append(p[i])
        up, low = ((a, i), (b, j)) if first_up else ((b, j), (a, i))
        crossings.append(TrueCrossing(p[i], up[0], low[0], up[1], low[1]))
    return crossings if _apart_elsewhere(p, q, a == b, mean_width, places) else None


def _apart_elsewhere(p: Array, q: Array, same: bool, width: float, places: list[Array]) -> bool:
    """Return whether two strands touch only near their crossings, and tips nowhere."""
    i, j = np.arange(0, len(p), 3), np.arange(0, len(q), 3)
    gaps = np.linalg.norm(p[i][:, None] - q[j][None], axis=-1)
    if same:
        along = np.abs(i[:, None] - j[None]) * STEP_PX
        gaps = np.where(along < np.pi * MIN_BEND_WIDTHS * width, 1e9, gaps)
    clear = TIP_CLEARANCE_WIDTHS * width
    if min(gaps[0].min(), gaps[-1].min(), gaps[:, 0].min(), gaps[:, -1].min()) < clear:
        return False
    touching = p[i][np.any(gaps < TOUCH_WIDTHS * width, axis=1)]
    if not len(touching):
        return True
    if not places:
        return False
    reach = np.linalg.norm(touching[:, None] - np.array(places)[None], axis=-1).min(axis=1)
    return bool(np.all(reach < CROSSING_REACH_WIDTHS * width))


def intersections(p: Array, q: Array) -> list[tuple[int, int, float]]:
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
