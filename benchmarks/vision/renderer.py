"""Draw cables as lit tubes on a table top, with the truth beside the picture.

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
from cable_curves import Array, CableCurve, TrueCrossing

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


@dataclass(frozen=True, eq=False)
class Rendered:
    """A picture and its truth.

    Attributes:
        rgb: (height, width, 3).
        labels: (height, width): 0 for the table, i + 1 where cable i is what one sees.
    """

    rgb: Picture
    labels: npt.NDArray[np.uint8]


def render(
    surface: npt.NDArray[np.float32],
    cables: tuple[CableCurve, ...],
    crossings: tuple[TrueCrossing, ...],
    colours: Array,
    light: Light,
    random: np.random.Generator,
) -> Rendered:
    """Draw cables of colours (n, 3) on a table top (height, width, 3)."""
    height, width = surface.shape[:2]
    fine = cv2.resize(surface, (FINE * width, FINE * height), interpolation=cv2.INTER_CUBIC)
    lifts = [_lift(i, cables, crossings) for i in range(len(cables))]
    canvas = _Canvas(fine, light)
    for cable, lift in zip(cables, lifts, strict=True):
        canvas.cast(cable, lift)
    canvas.fall()
    for i, (cable, lift) in enumerate(zip(cables, lifts, strict=True)):
        canvas.draw(cable, lift, colours[i], i + 1)
    sharp = cv2.resize(canvas.rgb, (width, height), interpolation=cv2.INTER_AREA)
    return Rendered(_expose(sharp, light, random), _coarse(canvas.labels, len(cables)))


def paint_labels(
    size: tuple[int, int], cables: tuple[CableCurve, ...], crossings: tuple[TrueCrossing, ...]
) -> npt.NDArray[np.uint8]:
    """Return the labels (height, width) of cables in a picture of size (width, height)."""
    blank = np.zeros((FINE * size[1], FINE * size[0], 3), np.float32)
    canvas = _Canvas(blank, Light(0.0, 1.0))
    for i, cable in enumerate(cables):
        canvas.draw(cable, _lift(i, cables, crossings), np.zeros(3), i + 1)
    return _coarse(canvas.labels, len(cables))


def _coarse(labels: npt.NDArray[np.uint8], count: int) -> npt.NDArray[np.uint8]:
    """Return for each pixel the label that covers most of it."""
    size = (labels.shape[1] // FINE, labels.shape[0] // FINE)
    shares = [
        cv2.resize(np.float32(labels == i), size, interpolation=cv2.INTER_AREA)
        for i in range(count + 1)
    ]
    return np.argmax(shares, axis=0).astype(np.uint8)


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
        self.labels = np.zeros(surface.shape[:2], np.uint8)
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

    def draw(self, cable: CableCurve, lift: Array, colour: Array, label: int) -> None:
        """Draw a cable as a tube."""
        points = cable.points * FINE + (FINE - 1) / 2
        for start in range(0, len(points) - 1, CHUNK):
            stop = min(start + CHUNK + 1, len(points))
            self._chunk(points[start:stop], lift[start:stop], cable.width, colour, label)

    def _chunk(self, points: Array, lift: Array, width: float, colour: Array, label: int) -> None:
        radius = FINE * width / 2
        high, wide = self.labels.shape
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
        self.labels[window][seen] = label
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
