"""Table tops: plain, wood, brushed metal, fabric and black cloth, and what lies on them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.float32]

# What is drawn by lot; "black" is asked for by name.
SURFACES = ("plain", "wood", "metal", "fabric")
RAIL = np.array([0.72, 0.73, 0.75], np.float32)


def random_surface(random: np.random.Generator, size: tuple[int, int], kind: str) -> Image:
    """Return a table top (height, width, 3), RGB from 0 to 1, for a size (width, height).

    The kind is one of SURFACES, "black", or the path of a photograph, of which a part is taken.
    """
    if "." in kind:
        return _photograph(random, size, Path(kind))
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


def _photograph(random: np.random.Generator, size: tuple[int, int], path: Path) -> Image:
    """Return a part of a photograph, enlarged by up to 1.3 and mirrored by lot."""
    whole = cv2.imread(str(path))
    if whole is None:
        raise ValueError(f"{path} is no picture that OpenCV can read")
    rgb = cv2.cvtColor(whole, cv2.COLOR_BGR2RGB)
    scale = max(np.divide(size, rgb.shape[1::-1])) * random.uniform(1, 1.3)
    rgb = cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    rgb = cv2.resize(rgb, np.maximum(size, rgb.shape[1::-1]).tolist())
    left, top = (random.integers(n - m + 1) for n, m in zip(rgb.shape[1::-1], size, strict=True))
    part = rgb[top : top + size[1], left : left + size[0]]
    if random.uniform() < 0.5:
        part = part[:, ::-1]
    return (part / 255).astype(np.float32)


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
