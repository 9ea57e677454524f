"""Draw cables as lit tubes on a table top.

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

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]
Picture = npt.NDArray[np.uint8]

FINE = 2  # sub-pixels per pixel and axis
CHUNK = 20  # points of a strand drawn at a time
RISE_WIDTHS = 2.5  # how far before a crossing the upper strand begins to rise


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
    ambient: float
    specular: float
    falloff: float
    shadow: float
    exposure: float
    blur: float
    noise: float
    black: float = 0.0
    motion: float = 0.0
    jpeg: float = 0.0

    @property
    def direction(self) -> Array:
        """Towards the light, (3,): x right, y down in the picture, z to the camera."""
        x, y = np.cos(self.azimuth), np.sin(self.azimuth)
        flat = np.cos(self.elevation)
        return np.array([flat * x, flat * y, np.sin(self.elevation)])


def render(
    surface: Image,
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

    def __init__(self, surface: Image, light: Light) -> None:
        self.rgb = surface.copy()
        self._light = light
        self._heights, self._dimmed, self._raised = (
            np.zeros(surface.shape[:2], np.float32) for _ in range(3)
        )

    def cast(self, cable: CableCurve, lift: Array) -> None:
        """Add a cable's shadow: on the table, and of its raised parts on strands below."""
        direction = self._light.direction
        slope = -direction[:2] / direction[2]
        over = lift - cable.width / 2
        for layer, height, where in (
            (self._dimmed, lift, lift > 0),
            (self._raised, over, over > 0.6 * cable.width),
        ):
            points = cable.points + height[:, None] * slope
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
        window = (slice(y0, y1), slice(x0, x1))
        seen = (inside & (top > self._heights[window].ravel())).reshape(x.shape)
        tilt = np.minimum(offset / radius, 1)
        normal = np.column_stack([across * tilt[:, None], rise]).reshape(*x.shape, 3)
        tone = self._lit(normal, colour)
        low = (z < width * 0.9).reshape(x.shape)
        tone *= 1 - self._light.shadow * (self._raised[window] * low)[..., None]
        self.rgb[window][seen] = tone[seen]
        self._heights[window][seen] = top.reshape(x.shape)[seen]

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


def _expose(sharp: Image, light: Light, random: np.random.Generator) -> Picture:
    """Return what the camera makes of light (height, width, 3)."""
    height, width = sharp.shape[:2]
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, width), np.linspace(-0.5, 0.5, height))
    fade = 1 + light.falloff * (x * np.cos(light.azimuth) + y * np.sin(light.azimuth))
    lens = cv2.GaussianBlur(sharp, (0, 0), light.blur)
    if light.motion:
        lens = cv2.filter2D(lens, -1, _streak(light.motion, light.azimuth))
    levels = 255 * light.exposure * lens * fade[..., None].astype(np.float32) - light.black
    noisy = levels + random.normal(0, light.noise, levels.shape)
    rgb = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    if not light.jpeg:
        return rgb
    quality = [cv2.IMWRITE_JPEG_QUALITY, int(light.jpeg)]
    chroma = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420]
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), quality + chroma)
    return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def _streak(length: float, azimuth: float) -> Image:
    """Return the kernel of a motion over a length [px] in a direction [rad]."""
    half = int(np.ceil(length / 2)) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    way = length / 2 * np.array([np.cos(azimuth), np.sin(azimuth)])
    ends = np.rint((np.stack([half - way, half + way])) * 16).astype(int)
    cv2.line(kernel, ends[0].tolist(), ends[1].tolist(), (1.0,), 1, cv2.LINE_AA, 4)
    return kernel / kernel.sum()
