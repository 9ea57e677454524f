"""A board with its third dimension: the plate with all that stands on it, and the wires.

                 board               panel
    origin       lower left          centre of the plate
    x            to the right        up on the board, away from the robot
    y            up                  to the left on the board

A terminal that opens to the top of the board is entered towards -x of the panel, one that opens to
the bottom towards +x. Segments of ducts that lie in one line are one duct. Where ducts meet, each
reaches to the far wall of the other, whose near wall is open there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, takewhile

from remodel_production.core.board.board import Board, PlacedDevice
from remodel_production.core.board.formboard import Point
from remodel_production.core.catalogue import Catalogue, DeviceClass, DuctSize
from remodel_production.core.production import (
    Clip,
    SegmentKind,
    Side,
    Terminal,
    TerminalRef,
    Vector,
    Wire,
)
from remodel_states.core.wires import WireMaterial

# x, y [m] and the angle about z [rad].
Pose2 = tuple[float, float, float]

# A label is as large as its device allows, with a margin of a sixth of its side all around, which
# is a cell of it; and no larger than a camera needs [m].
_LABEL_MARGIN = 1 / 6
_LARGEST_LABEL_M = 0.024
_LABEL_STEP_M = 0.001
# Numbers of positions, lengths and forces keep so many decimals.
_DECIMALS = 6
# A route of so many points is straight.
_STRAIGHT_POINTS = 2
# Rows of devices run along the panel's y.
_ALONG_ROW = round(math.pi / 2, _DECIMALS)


@dataclass(frozen=True)
class PanelOpening:
    """A terminal in its device's frame [m], direction of insertion [rad], retention force [N].

    A width, depth, chamfer and force of 0 are not known.

    Attributes:
        insertion: force with which a spring clamp lets a ferrule in [N]; 0 if a screw closes it.
        screw: middle of the head of its screw; None if it has none.
    """

    name: str
    place: Vector
    insertion_yaw: float
    bore: float
    depth: float
    chamfer: float
    retention: float
    insertion: float
    screw: Vector | None


@dataclass(frozen=True)
class PanelDevice:
    """A device with its label: centre of its base [m], and its size along its x, y and z [m].

    Attributes:
        yaw: by which it is turned [rad].
    """

    name: str
    kind: str
    label: int
    label_size: float
    place: Point
    size: Vector
    openings: tuple[PanelOpening, ...]
    yaw: float = 0.0


@dataclass(frozen=True)
class PanelRail:
    """A mounting rail by its middle; it runs along its x [m]."""

    name: str
    pose: Pose2
    length: float
    width: float
    height: float


@dataclass(frozen=True)
class PanelDuct:
    """A duct, or the posts of a fork, by its middle; it runs along its x [m].

    A slot pitch of 0 means solid walls.
    """

    name: str
    pose: Pose2
    length: float
    width: float
    height: float
    slot_pitch: float = 0.0
    slot_width: float = 0.0
    slot_bottom: float = 0.0


@dataclass(frozen=True)
class PanelClip:
    """A clip for one wire: height of the wire's axis [m], length [m], retention force [N]."""

    name: str
    pose: Pose2
    wire_diameter: float
    height: float
    length: float
    retention: float


@dataclass(frozen=True)
class PanelWire:
    """A wire with its route [m], from end a to end b.

    Attributes:
        material: its properties; None for a section beyond the table of materials.
        length: [m] from tip to tip.
        ducts: that the route passes.
    """

    name: str
    a: TerminalRef
    b: TerminalRef
    colour: str
    section_mm2: float
    material: WireMaterial | None
    length: float
    route: tuple[Vector, ...]
    ducts: tuple[str, ...]


@dataclass(frozen=True)
class Panel:
    """The plate with all that stands on it; `size` along x and y, and its thickness [m]."""

    name: str
    size: Vector
    devices: tuple[PanelDevice, ...]
    rails: tuple[PanelRail, ...]
    ducts: tuple[PanelDuct, ...]
    clips: tuple[PanelClip, ...]
    wires: tuple[PanelWire, ...]


def panel_of(board: Board, catalogue: Catalogue) -> Panel:
    """Return the panel of a board, with the sizes that the catalogue has."""
    return _Maker(board, catalogue).panel()


class _Maker:
    """Makes the panel of one board."""

    def __init__(self, board: Board, catalogue: Catalogue) -> None:
        self._board = board
        self._catalogue = catalogue
        self._left, self._low, self._right, self._top = self._bounds()
        self._routed = [wire for wire in board.order.wires if wire.name in board.routes]
        self._sections = {end: w.section_mm2 for w in self._routed for end in (w.a, w.b)}

    def panel(self) -> Panel:
        ducts, duct_of = self._ducts() if self._board.is_cabinet else ((), {})
        forks, clips, forks_of = self._holders()
        rules = self._catalogue.cabinet if self._board.is_cabinet else self._catalogue.formboard
        size = (self._top - self._low, self._right - self._left, rules.plate_thickness)
        devices = tuple(
            self._device(device, label) for label, device in enumerate(self._board.devices)
        )
        heights = {TerminalRef(d.name, o.name): o.place[2] for d in devices for o in d.openings}
        return Panel(
            self._board.order.name,
            _rounded(size),
            devices,
            rails=tuple(self._rails()) if self._board.is_cabinet else (),
            ducts=(*ducts, *forks),
            clips=clips,
            wires=tuple(
                self._wire(wire, heights, duct_of, forks_of[wire.name]) for wire in self._routed
            ),
        )

    def _bounds(self) -> tuple[float, float, float, float]:
        """Return left, low, right and top of the plate, in the board's frame [m]."""
        board, catalogue = self._board, self._catalogue
        xs, ys = (
            [d.centre[axis] + sign * d.half_extent[axis] for d in board.devices for sign in (-1, 1)]
            or [0.0]  # of a board without devices
            for axis in (0, 1)
        )
        margin = catalogue.formboard.plate_margin
        beside = 0.0
        if board.is_cabinet:
            margin, beside = catalogue.cabinet.plate_margin, catalogue.cabinet.duct.width / 2
        for point in (p for line in board.lines.values() for p in line):
            xs += [point[0] - beside, point[0] + beside]
            ys += [point[1] - beside, point[1] + beside]
        return min(xs) - margin, min(ys) - margin, max(xs) + margin, max(ys) + margin

    def _at(self, point: Point) -> Point:
        """Return a point of the board in the panel's frame."""
        x, y = point
        return (
            _number(y - (self._low + self._top) / 2),
            _number((self._left + self._right) / 2 - x),
        )

    def _device(self, device: PlacedDevice, label: int) -> PanelDevice:
        component = device.component
        part = self._catalogue.device_class(component)
        width, depth = device.size
        room = min(width, depth) / (1 + 2 * _LABEL_MARGIN)
        return PanelDevice(
            component.name,
            component.kind,
            label,
            math.floor(min(_LARGEST_LABEL_M, room) / _LABEL_STEP_M + 1e-6) * _LABEL_STEP_M,
            place=self._at(device.centre),
            size=_rounded((depth, width, part.height_m)),
            openings=tuple(
                self._opening(device, terminal, part) for terminal in component.terminals
            ),
            yaw=_number(device.turn),
        )

    def _opening(self, device: PlacedDevice, terminal: Terminal, part: DeviceClass) -> PanelOpening:
        ref = TerminalRef(device.component.name, terminal.name)
        x, y = self._board.openings[ref]
        cos, sin = math.cos(device.turn), math.sin(device.turn)
        out, left = y - device.centre[1], device.centre[0] - x
        up, aside = cos * out + sin * left, cos * left - sin * out
        is_top = terminal.side is Side.TOP if self._board.is_cabinet else up > 0
        section = self._sections.get(ref)
        screw = None
        if part.screw_m is not None:
            behind = -part.screw_m if is_top else part.screw_m
            screw = _rounded((up + behind, aside, part.height_m))
        clamp = (0.0, 0.0, 0.0, 0.0, 0.0)
        if section:
            # A person places a wire beyond the table; its clamp has the size of the nearest one.
            material = self._catalogue.nearest_material(section)
            bore = material.diameter + self._catalogue.clamp_play_m
            depth = material.ferrule_length + self._catalogue.clamp_beyond_ferrule_m
            size = self._catalogue.clamp(section)
            insertion = size.insertion_n if part.has_springs else 0.0
            clamp = (_number(bore), _number(depth), size.chamfer_m, size.retention_n, insertion)
        return PanelOpening(
            terminal.name,
            _rounded((up, aside, part.opening_m)),
            math.pi if is_top else 0.0,
            *clamp,
            screw=screw,
        )

    def _rails(self) -> Iterator[PanelRail]:
        """Yield a rail below each row of devices, all as long as the longest row."""
        rows = {device.centre[1] for device in self._board.devices}
        if not rows:
            return
        size = self._catalogue.cabinet.rail
        left = min(d.centre[0] - d.size[0] / 2 for d in self._board.devices)
        right = max(d.centre[0] + d.size[0] / 2 for d in self._board.devices)
        for index, y in enumerate(sorted(rows, reverse=True), start=1):
            pose = (*self._at(((left + right) / 2, y)), _ALONG_ROW)
            yield PanelRail(f"R{index}", pose, round(right - left, 6), size.width, size.height)

    def _ducts(self) -> tuple[tuple[PanelDuct, ...], dict[str, str]]:
        """Return the ducts, and the name of the one that each segment belongs to."""
        size = self._catalogue.cabinet.duct
        ducts, duct_of = [], {}
        for name, segments in _straight(self._board.lines).items():
            duct_of.update(dict.fromkeys(segments, name))
            ducts.append(self._duct(name, segments, size))
        return tuple(ducts), duct_of

    def _duct(self, name: str, segments: Sequence[str], size: DuctSize) -> PanelDuct:
        lines = self._board.lines
        points = [point for segment in segments for point in lines[segment]]
        start, end = min(points), max(points)
        across = 1 if start[1] == end[1] else 0
        others = [line for other, line in lines.items() if other not in segments]
        # To the far wall of a duct that it meets at its end.
        is_joint = [
            any(p == tip and p[across] != q[across] for p, q in _both(others))
            for tip in (start, end)
        ]
        beyond = [size.width / 2 if joint else 0.0 for joint in is_joint]
        length = math.dist(start, end) + sum(beyond)
        shift = (beyond[1] - beyond[0]) / 2
        middle = [(p + q) / 2 for p, q in zip(start, end, strict=True)]
        middle[1 - across] += shift
        return PanelDuct(
            name,
            (*self._at((middle[0], middle[1])), _ALONG_ROW if across else 0.0),
            round(length, _DECIMALS),
            size.width,
            size.height,
            slot_pitch=size.slot_pitch,
            slot_width=size.slot_width,
            slot_bottom=size.slot_bottom,
        )

    def _holders(
        self,
    ) -> tuple[tuple[PanelDuct, ...], tuple[PanelClip, ...], dict[str, tuple[str, ...]]]:
        """Return the forks and clips of a formboard, and the forks of each wire, by its name.

        What one wire passes is a clip; what several pass is a fork, as wide as they need.
        """
        order, rules = self._board.order, self._catalogue.formboard
        passed = {
            wire.name: order.clips_of(wire) if wire.route and not self._board.is_cabinet else ()
            for wire in self._routed
        }
        forks: dict[str, PanelDuct] = {}
        clips = []
        for clip in order.clips:
            thick = [self._diameter(wire) for wire in self._routed if clip in passed[wire.name]]
            if not thick:
                continue
            pose = (*self._at(self._board.clips[clip.name]), self._along(clip))
            if len(thick) == 1:
                size = (rules.clip.height, rules.clip.length, rules.clip.retention)
                clips.append(PanelClip(clip.name, pose, thick[0], *size))
            else:
                # Two wires beside each other, and the others above them.
                least = max(rules.fork.width, 2.2 * max(thick))
                passing = [wire for wire in self._routed if clip in passed[wire.name]]
                aside, spread = self._spread(pose, passing)
                x, y, yaw = pose
                middle = (x - aside * math.sin(yaw), y + aside * math.cos(yaw))
                width = round(max(least, spread), _DECIMALS)
                forks[clip.name] = PanelDuct(
                    clip.name,
                    (_number(middle[0]), _number(middle[1]), yaw),
                    rules.fork.length,
                    width=width,
                    height=rules.fork.height,
                )
        forks_of = {
            name: tuple(clip.name for clip in held if clip.name in forks)
            for name, held in passed.items()
        }
        return tuple(forks.values()), tuple(clips), forks_of

    def _spread(self, pose: Pose2, wires: Sequence[Wire]) -> tuple[float, float]:
        """Return how far beside a clip the wires that pass it straight are, and a fork's width [m].

        Both are across the direction of the clip's pose.
        """
        x, y, yaw = pose
        asides = []
        for wire in wires:
            route = self._board.routes[wire.name]
            if len(route) > _STRAIGHT_POINTS:
                continue
            (ax, ay), (bx, by) = (
                (math.cos(yaw) * (p - x) + math.sin(yaw) * (q - y),
                 math.cos(yaw) * (q - y) - math.sin(yaw) * (p - x))
                for p, q in map(self._at, route)
            )  # fmt: skip
            asides.append(ay - (by - ay) * ax / (bx - ax) if ax != bx else 0.0)
        if not asides:
            return 0.0, 0.0
        low, high = min(asides), max(asides)
        return (low + high) / 2, high - low + self._catalogue.formboard.fork.play

    def _along(self, clip: Clip) -> float:
        """Return the direction of a clip's wire in the panel's frame [rad]."""
        segments = {segment.name: segment for segment in self._board.order.segments}
        if all(segment.kind is SegmentKind.STRAIGHT for segment in segments.values()):
            return _ALONG_ROW
        segment = segments.get(clip.segment) or next(
            s for s in segments.values() if clip.node in (s.start, s.end)
        )
        (x1, y1), (x2, y2) = self._board.lines[segment.name]
        return round(math.atan2(x1 - x2, y2 - y1), _DECIMALS)

    def _diameter(self, wire: Wire) -> float:
        material = self._catalogue.material(wire.section_mm2)
        return material.diameter if material else 0.0

    def _wire(
        self,
        wire: Wire,
        heights: Mapping[TerminalRef, float],
        duct_of: Mapping[str, str],
        forks: Sequence[str],
    ) -> PanelWire:
        points = self._board.routes[wire.name]
        between = self._height_between()
        zs = [heights[wire.a], *[between] * (len(points) - 2), heights[wire.b]]
        ducts = [duct_of[segment] for segment in wire.route if segment in duct_of]
        return PanelWire(
            wire.name,
            wire.a,
            wire.b,
            wire.colour,
            wire.section_mm2,
            self._catalogue.material(wire.section_mm2),
            length=round(self._board.length_of(wire), _DECIMALS),
            route=tuple((*self._at(point), z) for point, z in zip(points, zs, strict=True)),
            # Several segments in a row belong to one duct.
            ducts=(*(name for name, _ in groupby(ducts)), *forks),
        )

    def _height_between(self) -> float:
        """Return the height of a route between its terminals [m]: half that of the ducts."""
        if self._board.is_cabinet:
            return round(self._catalogue.cabinet.duct.height / 2, _DECIMALS)
        return self._catalogue.formboard.clip.height


def _straight(lines: Mapping[str, tuple[Point, Point]]) -> dict[str, tuple[str, ...]]:
    """Return the segments that lie in one line and touch, by the name that they share."""
    found: list[list[str]] = []
    for name, (start, end) in lines.items():
        row = next((row for row in found if _goes_on(lines[row[-1]], (start, end))), None)
        if row is None:
            found.append([name])
        else:
            row.append(name)
    named: dict[str, tuple[str, ...]] = {}
    for row in found:
        same = takewhile(lambda letters: len({*letters}) == 1, zip(*row, strict=False))
        shared = "".join(letters[0] for letters in same).rstrip(".")
        named[shared if shared and shared not in named else row[0]] = tuple(row)
    return named


def _goes_on(before: tuple[Point, Point], after: tuple[Point, Point]) -> bool:
    is_level = [line[0][1] == line[1][1] for line in (before, after)]
    return is_level[0] == is_level[1] and bool({*before} & {*after})


def _both(lines: Sequence[tuple[Point, Point]]) -> Iterator[tuple[Point, Point]]:
    """Yield each line in both directions."""
    for start, end in lines:
        yield start, end
        yield end, start


def _rounded(values: Sequence[float]) -> Vector:
    x, y, z = map(_number, values)
    return x, y, z


def _number(value: float) -> float:
    # Without minus zero.
    return round(value, _DECIMALS) + 0.0
