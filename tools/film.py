#!/usr/bin/env python3
"""Make a small moving picture of a recorded run.

Usage: film.py FOLDER FILE.webp

FOLDER holds the numbered pictures that `record:=FOLDER` of cell.launch or order.launch writes. The
moving picture is as good as 1 MB allows.
"""

import sys
from pathlib import Path

import cv2

FRAMES, WIDTH_PX = 120, 560
SHOWN_MS, LAST_MS = 100, 2500
LIMIT_BYTES = 1_000_000
QUALITIES = range(70, 9, -10)


def main() -> int:
    """Write the moving picture; return the exit code."""
    folder, target = map(Path, sys.argv[1:])
    files = sorted(folder.glob("[0-9]*.jpg"))
    if not files:
        print(f"film: {folder} holds no pictures; record a run into it with record:={folder}")
        return 1
    last = len(files) - 1
    chosen = sorted({round(i * last / (FRAMES - 1)) for i in range(FRAMES)})
    film = cv2.Animation()
    film.frames = [_small(files[i]) for i in chosen]
    film.durations = [SHOWN_MS] * (len(chosen) - 1) + [LAST_MS]
    for quality in QUALITIES:
        cv2.imwriteanimation(str(target), film, [cv2.IMWRITE_WEBP_QUALITY, quality])
        if target.stat().st_size <= LIMIT_BYTES:
            break
    print(
        f"{target}: {len(chosen)} of {len(files)} pictures in {sum(film.durations) / 1000:.0f} s, "
        f"{target.stat().st_size / 1000:.0f} kB"
    )
    return 0 if target.stat().st_size <= LIMIT_BYTES else 1


def _small(file: Path) -> cv2.typing.MatLike:
    picture = cv2.imread(str(file))
    height = round(picture.shape[0] * WIDTH_PX / picture.shape[1])
    return cv2.resize(picture, (WIDTH_PX, height), interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    sys.exit(main())
