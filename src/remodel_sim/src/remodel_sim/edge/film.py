"""Keep a run as pictures: numbered ones, a film, and a strip of a few of them on one sheet."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from remodel_sim.core.faults import FilmError

Image = npt.NDArray[np.uint8]

FILM_HZ = 10.0
# Motion JPEG needs nothing but OpenCV, to be written as to be seen.
CODEC = "MJPG"
STRIP_COLUMNS, STRIP_ROWS = 4, 3
STRIP_WIDTH_PX = 400  # of each picture on the sheet


class Film:
    """Writes pictures into a folder as they come: 0001.jpg and so on, film.avi, strip.png."""

    def __init__(self, folder: Path) -> None:
        """Make the folder; raises FilmError when it cannot be, or holds pictures already."""
        self._folder = folder
        self._files: list[Path] = []
        self._writer: cv2.VideoWriter | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            there = next(folder.iterdir(), None)
        except OSError as error:
            raise FilmError(f"record: {folder} cannot be written to: {error}") from error
        if there is not None:
            raise FilmError(f"record: {folder} holds {there.name} already; name an empty folder")

    def add(self, rgb: Image) -> None:
        """Write a picture, (height, width, 3); all of one size; raises FilmError."""
        bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
        file = self._folder / f"{len(self._files) + 1:04d}.jpg"
        _write(file, bgr)
        self._files.append(file)
        if self._writer is None:
            height, width = rgb.shape[:2]
            self._writer = cv2.VideoWriter(
                str(self._folder / "film.avi"),
                cv2.VideoWriter_fourcc(*CODEC),
                FILM_HZ,
                (width, height),
            )
        self._writer.write(bgr)

    def close(self) -> None:
        """End the film, and make the strip; without pictures there is neither.

        Raises FilmError when the strip cannot be written.
        """
        if self._writer is None:
            return
        self._writer.release()
        count = min(len(self._files), STRIP_COLUMNS * STRIP_ROWS)
        chosen = np.linspace(0, len(self._files) - 1, count).round().astype(int)
        tiles = [_tile(self._files[i]) for i in chosen]
        tiles += [np.full_like(tiles[0], 255)] * (-count % STRIP_COLUMNS)
        rows = [
            np.hstack(tiles[i : i + STRIP_COLUMNS]) for i in range(0, len(tiles), STRIP_COLUMNS)
        ]
        _write(self._folder / "strip.png", np.vstack(rows))


def _write(file: Path, bgr: Image) -> None:
    # OpenCV's own writer of PNG says that all is well on a full disk.
    _, encoded = cv2.imencode(file.suffix, bgr)
    try:
        file.write_bytes(encoded.tobytes())
    except OSError as error:
        raise FilmError(f"record: {file} cannot be written: {error}") from error


def _tile(file: Path) -> Image:
    picture = cv2.imread(str(file))
    height = round(picture.shape[0] * STRIP_WIDTH_PX / picture.shape[1])
    return np.asarray(
        cv2.resize(picture, (STRIP_WIDTH_PX, height), interpolation=cv2.INTER_AREA), np.uint8
    )
