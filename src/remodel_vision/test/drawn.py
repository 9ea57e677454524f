"""Pictures of boxes and wires, drawn ray by ray: no engine, no world, some tenths of a second.

Each has the blur and the noise of the simulator's cameras.
"""

import math
from functools import cache, lru_cache
from itertools import pairwise

import cv2
import numpy as np

from remodel_states.core.wires import rgbs_of
from remodel_work.camera import Picture, View
from remodel_work.component_shape import FERRULE_RGB, PLATE_RGB, Box, component_boxes
from remodel_work.fixtures import duct_boxes, rail_box
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

TABLE = Box((0.5, 0.0, -0.023), (3.0, 3.0, 0.04), (0.36, 0.31, 0.27))
BLUR_PX, NOISE_LEVELS, DEPTH_NOISE_M = 0.5, 3.0, 0.001
# What faces away from the light has this share of its colour.
AMBIENT = 0.55
LIGHT = np.array([0.4, -0.3, 1.2]) / math.hypot(0.4, 0.3, 1.2)
STEP_M = 0.0004
FAR_M = 2.5
NOISE_APART = 997
ARCH_TOP_M, ARCH_Y, ARCH_SPAN_M = 0.115, -0.05, 0.30
CORNERS = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)


def along(points, n=40):
    """Return the nodes of a wire (m, 3) [m] from point to point, n on each leg."""
    legs = [np.linspace(a, b, n, endpoint=False) for a, b in pairwise(np.array(points, float))]
    return np.concatenate([*legs, np.array(points[-1:], float)])


def bow(wire, aside=0.008):
    """Return the nodes of a wire that lies in a slight bow along y, (n, 3) [m], from end a on."""
    along_y = np.linspace(-0.5, 0.5, 41)
    x = 0.5 + aside * np.cos(math.pi * along_y)
    return np.column_stack([x, wire.length * along_y, np.full(41, wire.radius)])


def arch():
    """Return the nodes of a wire that stands out of the plate across it, (n, 3) [m].

    It arches along x at ARCH_Y, higher than a hand travels.
    """
    x = np.linspace(-ARCH_SPAN_M / 2, ARCH_SPAN_M / 2, 61)
    z = 0.003 + (ARCH_TOP_M - 0.003) * np.cos(math.pi * x / ARCH_SPAN_M)
    return np.column_stack([BOARD.position[0] + x, np.full(61, ARCH_Y), z])


def tip_of(nodes, end=WireEnd.A):
    """Return a wire's tip (3,) [m], and its direction out of the wire."""
    tip, inner = (nodes[0], nodes[1]) if end is WireEnd.A else (nodes[-1], nodes[-2])
    return tip, (tip - inner) / np.linalg.norm(tip - inner)


@cache
def boxes_of(panel, *, labels=True):
    """Return what stands on a panel and below it: boxes, each with its frame in the world."""
    board = panel.world_from_panel
    poses = {part.id: board @ part.panel_from_component for part in panel.components}
    return standing(panel, board, poses, labels=labels)


def standing(panel, board, poses, *, labels=True):
    """Return the boxes of a panel that lies elsewhere, and of components at poses, world frame."""
    plate = Box((0.0, 0.0, -panel.size[2] / 2), panel.size, PLATE_RGB)
    found = [(TABLE, Pose.level(0.0, 0.0, 0.0)), (plate, board)]
    for duct in panel.ducts:
        found += [(box, board @ duct.panel_from_duct) for box in duct_boxes(duct, panel.ducts)]
    found += [(rail_box(rail), board @ rail.panel_from_rail) for rail in panel.rails]
    for part in panel.components:
        found += [(box, poses[part.id]) for box in component_boxes(part, label=labels)]
    return tuple(found)


def picture(view, boxes, wires=(), *, seed=0, light=1.0):
    """Return a colour and depth picture.

    Args:
        view: of the camera.
        boxes: each with its frame in the world, as from `boxes_of`.
        wires: pairs of a wire and its nodes (n, 3) [m], from end a on.
        seed: of the noise.
        light: share of the usual one.
    """
    at = view.world_from_camera
    seen_from = (at.position.tobytes(), at.quaternion.tobytes())
    rgb, depth = (part.copy() for part in _drawn_boxes(view.lens, seen_from, boxes))
    for wire, nodes in wires:
        _draw_wire(view, rgb, depth, wire, np.asarray(nodes, float))
    seen = light * cv2.GaussianBlur(rgb, (0, 0), BLUR_PX) + _noise(NOISE_LEVELS, rgb.shape, seed)
    np.clip(np.rint(seen, out=seen), 0, 255, out=seen)
    depth += _noise(DEPTH_NOISE_M, depth.shape, seed)
    return Picture(seen.astype(np.uint8), depth, view)


def _noise(level, shape, seed):
    """Return normal noise: from one long row of it, by the seed from elsewhere in it."""
    size, start = math.prod(shape), NOISE_APART * (seed % NOISE_APART)
    return _noise_row(level, size)[start : start + size].reshape(shape)


@cache
def _noise_row(level, size):
    normal = np.random.default_rng(size).standard_normal(size + NOISE_APART**2, dtype=np.float32)
    return np.float32(level) * normal


@lru_cache(maxsize=6)
def _drawn_boxes(lens, seen_from, boxes):
    """Draw boxes; cells that are read several times see them from equal places."""
    view = View(lens, Pose(*(np.frombuffer(part) for part in seen_from)))
    shape = (view.lens.height, view.lens.width)
    rgb, depth = np.zeros((*shape, 3), np.float32), np.full(shape, FAR_M)
    frames = [frame @ Pose(np.array(box.centre), _quaternion(box.rpy)) for box, frame in boxes]
    size = np.array([view.lens.width, view.lens.height])
    for (box, _), frame in zip(boxes, frames, strict=True):
        pixels = view.project(frame.apply(CORNERS * np.array(box.size)))
        low = np.clip(np.floor(pixels.min(axis=0)).astype(int), 0, size)
        high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + 1, 0, size)
        if (low < high).all():
            _draw_box(view, rgb, depth, box, frame, (low, high))
    return rgb, depth


def _quaternion(rpy):
    """Return the quaternion of a turn about the fixed axes x, y and z."""
    turn = Pose.level(0.0, 0.0, 0.0)
    for axis, angle in enumerate(rpy):
        imaginary = math.sin(angle / 2) * np.eye(3)[axis]
        turn = Pose(np.zeros(3), np.array([*imaginary, math.cos(angle / 2)])) @ turn
    return turn.quaternion


def _draw_box(view, rgb, depth, box, world_from_box, within):
    """Draw what of a box is nearer than what was drawn before; pixels `within` may show it."""
    low, high = within
    half = np.array(box.size, np.float32) / 2
    box_from_camera = world_from_box.inverse() @ view.world_from_camera
    area = (slice(low[1], high[1]), slice(low[0], high[0]))
    rays = _rays(view.lens)[area] @ box_from_camera.rotation.T.astype(np.float32)
    eye, rays = box_from_camera.position.astype(np.float32), np.where(rays == 0, 1e-12, rays)
    # Where a ray enters and leaves the room between each two faces.
    middle, width = -eye / rays, half / np.abs(rays)
    enters = middle - width
    at, leaves = enters.max(axis=-1), (middle + width).min(axis=-1)
    is_seen = (at <= leaves) & (at < depth[area])
    # The face that a ray enters by looks against it.
    axis = enters[is_seen].argmax(axis=-1)
    towards = -np.sign(rays[is_seen][np.arange(len(axis)), axis])
    facing = towards * (world_from_box.rotation.T @ LIGHT)[axis]
    shade = AMBIENT + (1 - AMBIENT) * np.maximum(0.0, facing)
    depth[area][is_seen] = at[is_seen]
    rgb[area][is_seen] = 255 * shade[:, None] * np.array(box.rgb)


@cache
def _rays(lens):
    """Return a ray through each pixel, (height, width, 3), of depth 1."""
    u, v = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
    flat = (np.stack([u, v], axis=-1) - lens.centre_px) / lens.focal_px
    return np.concatenate([flat, np.ones((*u.shape, 1))], axis=-1).astype(np.float32)


def _draw_wire(view, rgb, depth, wire, nodes):
    """Draw a wire with its ferrules as balls along its nodes."""
    lengths = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))]
    at = np.arange(0.0, lengths[-1], STEP_M)
    line = np.column_stack([np.interp(at, lengths, nodes[:, i]) for i in range(3)])
    colours = np.array(rgbs_of(wire.colour))[(at // 0.02).astype(int) % len(rgbs_of(wire.colour))]
    is_ferrule = np.minimum(at, lengths[-1] - at) < wire.ferrule_length
    colours[is_ferrule] = FERRULE_RGB
    far = view.world_from_camera.inverse().apply(line)[:, 2]
    radius_px = wire.radius * view.lens.focal_px / far
    reach = math.ceil(radius_px.max()) + 1
    offsets = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2), axis=-1).reshape(-1, 2)
    middles = view.project(line)
    pixels = np.rint(middles).astype(int)[:, None] + offsets
    away = np.linalg.norm(pixels - middles[:, None], axis=2) / radius_px[:, None]
    rises = np.sqrt(np.maximum(0.0, 1 - away**2))
    ball = far[:, None] - wire.radius * rises
    shades = 255 * (AMBIENT + (1 - AMBIENT) * rises)[..., None] * colours[:, None]
    u, v = pixels[..., 0], pixels[..., 1]
    inside = (away <= 1) & (u >= 0) & (v >= 0) & (u < depth.shape[1]) & (v < depth.shape[0])
    order = np.argsort(-ball[inside])  # the nearest last
    u, v, ball, shades = (part[inside][order] for part in (u, v, ball, shades))
    is_nearer = ball < depth[v, u]
    depth[v[is_nearer], u[is_nearer]] = ball[is_nearer]
    rgb[v[is_nearer], u[is_nearer]] = shades[is_nearer]
