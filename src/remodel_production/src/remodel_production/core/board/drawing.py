"""Draw a board as SVG: components, ducts or bundles, clips, and the wires in their colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from remodel_production.core.board.board import Board, PlacedDevice
from remodel_production.core.board.formboard import Point
from remodel_production.core.production import Wire

# Pixels of the drawing.
_WIDTH = 1600
_MARGIN = 40

_BUNDLE = 8
_OPENING = 5

# [m]: wires in one duct are drawn side by side, in this many lanes.
_DUCT_M = 0.060
_LANES = 15
_LANE_M = 0.0035
_LABEL_M = 0.012
_RAIL_M = 0.035

_COLOURS = {
    **{"BK": "#222222", "BN": "#8b5a2b", "RD": "#d62728", "OG": "#ff8c1a", "YE": "#d9b800"},
    **{"GN": "#2ca02c", "BU": "#1f6fd6", "VT": "#8a4fbf", "GY": "#888888", "WH": "#bdbdbd"},
    **{"PK": "#f29ac2", "TQ": "#2ab7b7", "GD": "#c9a227", "SR": "#a0a0a0"},
}
_UNKNOWN = "#555555"


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


def draw_board(board: Board) -> str:
    """Return the SVG of a board."""
    points = [point for line in board.lines.values() for point in line]
    points += board.openings.values()
    points += [device.centre for device in board.devices]
    xs, ys = zip(*(points or [(0.0, 0.0)]), strict=True)
    left, right = min(xs) - _DUCT_M, max(xs) + _DUCT_M
    low, top = min(ys) - _DUCT_M, max(ys) + _DUCT_M
    view = _View(left, top, (_WIDTH - 2 * _MARGIN) / (right - left))
    height = 2 * _MARGIN + view.scale * (top - low)
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height:.0f}" '
            'font-family="sans-serif">',
            f"<title>{escape(board.order.name)}</title>",
            f'<rect width="{_WIDTH}" height="{height:.0f}" fill="white"/>',
            *_segments(board, view),
            *_rails(board, view),
            *_devices(board, view),
            *_wires(board, view),
            *_clips(board, view),
            *_labels(board, view),
            "</svg>\n",
        )
    )


def _segments(board: Board, view: _View) -> Iterator[str]:
    stroke = "#e4e8ee" if board.is_cabinet else "#dddddd"
    width = _DUCT_M * view.scale if board.is_cabinet else _BUNDLE
    for name, (start, end) in board.lines.items():
        (x1, y1), (x2, y2) = view.place(start), view.place(end)
        yield (
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{stroke}" '
            f'stroke-width="{width:.1f}" stroke-linecap="square">'
            f"<title>{escape(name)}</title></line>"
        )


def _rails(board: Board, view: _View) -> Iterator[str]:
    """Draw the rails of a cabinet, on which its rows of devices stand."""
    if not board.is_cabinet:
        return
    rows: dict[float, list[PlacedDevice]] = {}
    for device in board.devices:
        rows.setdefault(device.centre[1], []).append(device)
    for y, devices in rows.items():
        left = min(device.centre[0] - device.size[0] / 2 for device in devices)
        right = max(device.centre[0] + device.size[0] / 2 for device in devices)
        (x1, at), (x2, _) = view.place((left - _LABEL_M, y)), view.place((right + _LABEL_M, y))
        yield (
            f'<line x1="{x1:.1f}" y1="{at:.1f}" x2="{x2:.1f}" y2="{at:.1f}" stroke="#c9c9c0" '
            f'stroke-width="{_RAIL_M * view.scale:.1f}"/>'
        )


def _devices(board: Board, view: _View) -> Iterator[str]:
    for device in board.devices:
        width, height = device.size
        x, y = view.place((device.centre[0] - width / 2, device.centre[1] + height / 2))
        title = " ".join(filter(None, (device.component.name, device.component.kind)))
        yield (
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width * view.scale:.1f}" '
            f'height="{height * view.scale:.1f}" rx="2" fill="#f7f7f4" stroke="#8a8a80" '
            f'stroke-width="0.8"><title>{escape(title)}</title></rect>'
        )
    size = min(_OPENING, 0.003 * view.scale)
    for ref, opening in board.openings.items():
        x, y = view.place(opening)
        yield (
            f'<rect x="{x - size / 2:.1f}" y="{y - size / 2:.1f}" width="{size:.1f}" '
            f'height="{size:.1f}" fill="#8a8a80"><title>{escape(str(ref))}</title></rect>'
        )


def _wires(board: Board, view: _View) -> Iterator[str]:
    wires = {wire.name: wire for wire in board.order.wires}
    for index, (name, route) in enumerate(board.routes.items()):
        wire = wires[name]
        offset = (index % _LANES - (_LANES - 1) / 2) * _LANE_M
        points = _beside(route, offset) if board.is_cabinet else route
        drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(view.place, points))
        title = f"{name}: {wire.a} to {wire.b}, {wire.colour} {wire.section_mm2:g} mm2"
        title += f", {board.length_of(wire):.2f} m"
        thick = 0.8 + 0.25 * wire.section_mm2**0.5
        # White and yellow need an edge to be seen; a second colour is dashed over the first.
        yield (
            f'<g fill="none" stroke-linejoin="round" stroke-width="{thick:.2f}">'
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
    return _COLOURS.get(wire.colour[start : start + 2], _UNKNOWN)


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
