"""Draw a board as SVG, to scale: components, rails, ducts or bundles, clips, wires in colours.

Terminals have their names as `data-terminal`; wires have theirs as `data-wire`, and the terminals
of their ends as `data-a` and `data-b`, so that a page knows what a person clicks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from remodel_production.core.board.board import Board, PlacedDevice
from remodel_production.core.board.formboard import Point
from remodel_production.core.board.panel import panel_of
from remodel_production.core.catalogue import Catalogue
from remodel_production.core.production import TerminalRef, Wire
from remodel_states.core.wires import hex_colours

# Pixels of the drawing.
_WIDTH = 1600
_MARGIN = 40

_BUNDLE = 8

# Wires in one duct are drawn side by side, in this many lanes over this part of its width.
_LANES = 15
_LANES_SHARE = 0.85
# [m]
_AROUND_M = 0.060
_LABEL_M = 0.012
_WALL_M = 0.002
# Of an opening whose size is not known [m].
_OPENING_M = 0.003

# On white paper; of the other colours, what wires look like.
_COLOURS = {
    **{"BK": "#222222", "BN": "#8b5a2b", "RD": "#d62728", "OG": "#ff8c1a", "YE": "#d9b800"},
    **{"GN": "#2ca02c", "BU": "#1f6fd6", "VT": "#8a4fbf", "GY": "#888888", "WH": "#bdbdbd"},
    **{"PK": "#f29ac2", "TQ": "#2ab7b7", "GD": "#c9a227", "SR": "#a0a0a0"},
}


@dataclass(frozen=True)
class _View:
    """What part of the board is drawn: a point of it, and the pixels of a metre."""

    left: float
    top: float
    scale: float

    def place(self, point: Point) -> Point:
        """Return where a point of the board is drawn."""
        x = _MARGIN + self.scale * (point[0] - self.left)
        return x, _MARGIN + self.scale * (self.top - point[1])


def draw_board(board: Board, catalogue: Catalogue) -> str:
    """Return the SVG of a board, with the sizes that the catalogue has."""
    points = [point for line in board.lines.values() for point in line]
    points += board.openings.values()
    points += [device.centre for device in board.devices]
    xs, ys = zip(*(points or [(0.0, 0.0)]), strict=True)
    left, right = min(xs) - _AROUND_M, max(xs) + _AROUND_M
    low, top = min(ys) - _AROUND_M, max(ys) + _AROUND_M
    view = _View(left, top, (_WIDTH - 2 * _MARGIN) / (right - left))
    height = 2 * _MARGIN + view.scale * (top - low)
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height:.0f}" '
            'font-family="sans-serif">',
            f"<title>{escape(board.order.name)}</title>",
            f'<rect width="{_WIDTH}" height="{height:.0f}" fill="white"/>',
            *(_ducts(board, catalogue, view) if board.is_cabinet else _bundles(board, view)),
            *_rails(board, catalogue, view),
            *_devices(board, view),
            *_openings(board, catalogue, view),
            *_wires(board, _LANES_SHARE * catalogue.cabinet.duct.width / _LANES, view),
            *_clips(board, view),
            *_labels(board, view),
            "</svg>\n",
        )
    )


def _bundles(board: Board, view: _View) -> Iterator[str]:
    for name, line in board.lines.items():
        yield _line(line, view, name, stroke="#dddddd", width=_BUNDLE)


def _ducts(board: Board, catalogue: Catalogue, view: _View) -> Iterator[str]:
    """Draw the fingers of all walls, and over them the ducts' floors: walls are open in joints."""
    size = catalogue.cabinet.duct
    finger = size.slot_pitch - size.slot_width
    dashes = f"{finger * view.scale:.2f} {size.slot_width * view.scale:.2f}"
    across = (size.width + 2 * _WALL_M) * view.scale
    for name, line in board.lines.items():
        yield _line(line, view, name, stroke="#9aa4b2", width=across, dashes=dashes)
    for name, line in board.lines.items():
        yield _line(line, view, name, stroke="#e4e8ee", width=size.width * view.scale)


def _line(
    line: tuple[Point, Point],
    view: _View,
    title: str,
    *,
    stroke: str,
    width: float,
    dashes: str = "",
) -> str:
    (x1, y1), (x2, y2) = map(view.place, line)
    # Floors of ducts that meet fill the corner; fingers stand along their duct only.
    style = f'stroke-dasharray="{dashes}"' if dashes else 'stroke-linecap="square"'
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{stroke}" '
        f'stroke-width="{width:.1f}" {style}><title>{escape(title)}</title></line>'
    )


def _rails(board: Board, catalogue: Catalogue, view: _View) -> Iterator[str]:
    """Draw the rails of a cabinet, on which its rows of devices stand."""
    if not board.is_cabinet or not board.devices:
        return
    left = min(device.centre[0] - device.size[0] / 2 for device in board.devices)
    right = max(device.centre[0] + device.size[0] / 2 for device in board.devices)
    for y in sorted({device.centre[1] for device in board.devices}):
        (x1, at), (x2, _) = view.place((left, y)), view.place((right, y))
        yield (
            f'<line x1="{x1:.1f}" y1="{at:.1f}" x2="{x2:.1f}" y2="{at:.1f}" stroke="#c9c9c0" '
            f'stroke-width="{catalogue.cabinet.rail.width * view.scale:.1f}"/>'
        )


def _devices(board: Board, view: _View) -> Iterator[str]:
    for device in board.devices:
        width, height = device.size
        x, y = view.place((device.centre[0] - width / 2, device.centre[1] + height / 2))
        title = " ".join(filter(None, (device.component.name, device.component.kind)))
        turned = _turned(device.turn, view.place(device.centre))
        yield (
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width * view.scale:.1f}" '
            f'height="{height * view.scale:.1f}" rx="2" fill="#f7f7f4" stroke="#8a8a80" '
            f'stroke-width="0.8"{turned}><title>{escape(title)}</title></rect>'
        )


def _turned(turn: float, about: Point) -> str:
    """Return the attribute that turns what is drawn to the left [rad] about a place."""
    x, y = about
    return f' transform="rotate({-math.degrees(turn):.1f} {x:.1f} {y:.1f})"' if turn else ""


def _openings(board: Board, catalogue: Catalogue, view: _View) -> Iterator[str]:
    """Draw the openings as wide and as deep as their wires need them."""
    for device in panel_of(board, catalogue).devices:
        for opening in device.openings:
            ref = TerminalRef(device.name, opening.name)
            x, y = board.openings[ref]
            width, depth = opening.bore or _OPENING_M, opening.depth or _OPENING_M
            top = y if opening.insertion_yaw else y + depth
            left, upper = view.place((x - width / 2, top))
            turned = _turned(device.yaw, view.place((x, y)))
            yield (
                f'<rect x="{left:.1f}" y="{upper:.1f}" width="{width * view.scale:.1f}" '
                f'height="{depth * view.scale:.1f}" fill="#8a8a80"{turned} '
                f"data-terminal={quoteattr(str(ref))}><title>{escape(str(ref))}</title></rect>"
            )


def _wires(board: Board, lane_m: float, view: _View) -> Iterator[str]:
    wires = {wire.name: wire for wire in board.order.wires}
    for index, (name, route) in enumerate(board.routes.items()):
        wire = wires[name]
        offset = (index % _LANES - (_LANES - 1) / 2) * lane_m
        points = _beside(route, offset) if board.is_cabinet else route
        drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(view.place, points))
        title = f"{name}: {wire.a} to {wire.b}, {wire.colour} {wire.section_mm2:g} mm2"
        title += f", {board.length_of(wire):.2f} m"
        thick = 0.8 + 0.25 * wire.section_mm2**0.5
        # White and yellow need an edge to be seen; a second colour is dashed over the first.
        yield (
            f'<g fill="none" stroke-linejoin="round" stroke-width="{thick:.2f}" '
            f"data-wire={quoteattr(name)} data-a={quoteattr(str(wire.a))} "
            f"data-b={quoteattr(str(wire.b))}>"
            f"<title>{escape(title)}</title>"
            f'<polyline points="{drawn}" stroke={quoteattr(_stroke(wire, 0))}/>'
        )
        if len(wire.colour) > 2:
            yield (
                f'<polyline points="{drawn}" stroke={quoteattr(_stroke(wire, 2))} '
                'stroke-dasharray="5 5"/>'
            )
        yield "</g>"


def _beside(route: tuple[Point, ...], offset: float) -> list[Point]:
    """Return a route through ducts, shifted within them; its ends stay."""
    if len(route) < 4:
        return list(route)
    moved = [route[0]]
    for index, (x, y) in enumerate(route[1:-1], start=1):
        is_first, is_last = index == 1, index == len(route) - 2
        moved.append((x if is_first or is_last else x + offset, y + offset))
    return [*moved, route[-1]]


def _stroke(wire: Wire, start: int) -> str:
    code = wire.colour[start : start + 2]
    return _COLOURS.get(code) or hex_colours(code)[0]


def _clips(board: Board, view: _View) -> Iterator[str]:
    for name, place in board.clips.items():
        x, y = view.place(place)
        yield (
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="white" stroke="#b3400e" '
            f'stroke-width="2"><title>{escape(name)}</title></circle>'
        )


def _labels(board: Board, view: _View) -> Iterator[str]:
    for device in board.devices:
        yield _label(board, device, view)


def _label(board: Board, device: PlacedDevice, view: _View) -> str:
    x, y = view.place(device.centre)
    name = escape(device.component.name)
    size = max(4.0, min(11.0, _LABEL_M * view.scale))
    if not board.is_cabinet:
        return f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" font-size="11">{name}</text>'
    # Along the device, which is higher than it is wide.
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:.1f}" text-anchor="middle" '
        f'dominant-baseline="central" transform="rotate(-90 {x:.1f} {y:.1f})">{name}</text>'
    )
