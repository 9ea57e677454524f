"""Detect the cables in a picture.

Prints what was found, for people or as JSON, and draws it. The exit code is 0 for a reliable
result, 1 for one with warnings, which it prints, and 2 when a file cannot be read or written.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from remodel_vision.cables import Crossing, DetectedCable, Detection, detect_cables
from remodel_vision.cables.lines import sketch
from remodel_vision.colour import Pixels

# ITU-T T.81, B.1.1: a marker is FF and a byte that is neither 0 nor the number of a restart.
JPEG_MARKER = re.compile(rb"\xff+([^\x00\xd0-\xd7\xff])", re.DOTALL)
START_OF_IMAGE, END_OF_IMAGE = b"\xff\xd8", 0xD9


class PictureFileError(Exception):
    """A file is no picture, or is truncated."""


def read_picture(file: Path) -> Pixels:
    """Return the picture in a file, (height, width, 3), RGB, as a viewer shows it.

    It is turned as its EXIF data say; grey pictures, palettes and 16 bits become RGB of 8 bits, and
    transparency is ignored.

    Raises:
        PictureFileError: when the file cannot be read, or ends too early.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise PictureFileError(f"{file} cannot be read: {error.strerror}") from error
    # OpenCV refuses parts of files of all other formats.
    if data.startswith(START_OF_IMAGE) and not _is_whole_jpeg(data):
        raise PictureFileError(f"{file} ends in the middle of its picture; copy it again")
    try:
        bgr = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        bgr = None
    if bgr is None:
        raise PictureFileError(
            f"{file} is no picture that OpenCV reads, or is damaged; give a whole PNG, JPEG, BMP, "
            "TIFF or WebP"
        )
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)


def _is_whole_jpeg(data: bytes) -> bool:
    """Return whether a JPEG picture reaches its end marker, past those of previews within it."""
    at = len(START_OF_IMAGE)
    while (marker := JPEG_MARKER.search(data, at)) is not None:
        if marker[1][0] == END_OF_IMAGE:
            return True
        at = marker.end() + int.from_bytes(data[marker.end() : marker.end() + 2], "big")
    return False


def main(arguments: list[str]) -> int:
    """Run the command; return its exit code."""
    parser = argparse.ArgumentParser("detect_cables", description=__doc__)
    parser.add_argument("image", type=Path, help="PNG, JPEG, BMP, TIFF, WebP")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--draw", type=Path, metavar="OUT.png", help="write what was found")
    known = parser.add_argument_group("what is known of the picture")
    known.add_argument(
        "--colour",
        type=_colour,
        action="append",
        default=[],
        metavar="R,G,B",
        help="of the cables, 0 to 255; again for another colour",
    )
    known.add_argument(
        "--width",
        type=float,
        action="append",
        default=[],
        metavar="PX",
        help="of the cables; again for another width",
    )
    known.add_argument("--mask", type=Path, help="picture, black where no cable can be")
    known.add_argument("--background", type=Path, help="the same view without the cables")
    options = parser.parse_args(arguments)
    try:
        rgb = read_picture(options.image)
        mask = read_picture(options.mask).max(axis=2) if options.mask else None
        background = read_picture(options.background) if options.background else None
        found = detect_cables(rgb, mask, options.colour, options.width, background)
    except PictureFileError as error:
        return _refuse(str(error))
    except ValueError as error:
        return _refuse(f"{options.image}: {error}")
    if options.draw is not None:
        drawn = cv2.cvtColor(sketch(rgb, found), cv2.COLOR_RGB2BGR)
        try:
            written = cv2.imwrite(str(options.draw), drawn)
        except cv2.error:
            written = False
        if not written:
            return _refuse(f"{options.draw} cannot be written; name a .png in a folder that exists")
    print(json.dumps(as_dict(found)) if options.json else as_text(found))
    return 1 if found.warnings else 0


def _colour(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(level) for level in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no colour; write red, green and blue from 0 to 255, such as 200,30,30"
        ) from None


def _refuse(why: str) -> int:
    print(f"detect_cables: {why}", file=sys.stderr)
    return 2


def as_dict(found: Detection) -> dict[str, Any]:
    """Return a detection as plain values; pixels are columns and rows, whole ones are centres."""
    return {
        "cables": [_cable(cable) for cable in found.cables],
        "crossings": [_crossing(crossing) for crossing in found.crossings],
        "warnings": list(found.warnings),
    }


def _cable(cable: DetectedCable) -> dict[str, Any]:
    spline = cable.spline
    return {
        "centreline": cable.centreline.round(3).tolist(),
        "spline": {
            "t": spline.t.tolist(),
            "c_x": spline.c_x.tolist(),
            "c_y": spline.c_y.tolist(),
            "k": spline.k,
        },
        "tips": [
            {"point": t.point.tolist(), "outward": t.outward.tolist(), "end": t.end.value}
            for t in cable.tips
        ],
        "width": cable.width,
        "colour": cable.colour,
        "confidence": cable.confidence,
        "warnings": list(cable.warnings),
    }


def _crossing(crossing: Crossing) -> dict[str, Any]:
    return {
        "point": crossing.point.tolist(),
        "upper": crossing.upper,
        "lower": crossing.lower,
        "upper_at": crossing.upper_at,
        "lower_at": crossing.lower_at,
        "confidence": crossing.confidence,
    }


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def as_text(found: Detection) -> str:
    """Return a detection as lines for a person."""
    lines = [_count(len(found.cables), "cable") + ", " + _count(len(found.crossings), "crossing")]
    for i, cable in enumerate(found.cables):
        ends = ", ".join(f"{t.end.value} ({t.point[0]:.1f}, {t.point[1]:.1f})" for t in cable.tips)
        lines.append(
            f"cable {i}: {ends}; {cable.width:.1f} px wide; confidence {cable.confidence:.2f}"
        )
    lines += [
        f"crossing ({c.point[0]:.1f}, {c.point[1]:.1f}): cable {c.upper} over cable {c.lower}; "
        f"confidence {c.confidence:.2f}"
        for c in found.crossings
    ]
    return "\n".join([*lines, *(f"warning: {warning}" for warning in found.warnings)])
