import cv2
import numpy as np
import pytest

from remodel_sim.core.faults import FilmError
from remodel_sim.edge.film import Film


def grey(level):
    return np.full((48, 64, 3), level, np.uint8)


def test_a_run_becomes_numbered_pictures_a_film_and_a_strip(tmp_path):
    film = Film(tmp_path / "run")
    for level in range(0, 250, 10):
        film.add(grey(level))
    film.close()
    names = sorted(file.name for file in (tmp_path / "run").iterdir())
    assert names == [*(f"{i:04d}.jpg" for i in range(1, 26)), "film.avi", "strip.png"]
    assert cv2.imread(str(tmp_path / "run/0025.jpg"))[0, 0, 0] == pytest.approx(240, abs=3)
    frames = cv2.VideoCapture(str(tmp_path / "run/film.avi"))
    assert frames.get(cv2.CAP_PROP_FRAME_COUNT) == 25
    strip = cv2.imread(str(tmp_path / "run/strip.png"))
    assert strip.shape == (3 * 300, 4 * 400, 3)
    assert strip[10, 10, 0] < 10 and strip[-10, -10, 0] > 230, "from the first to the last"


def test_a_short_run_has_a_short_strip(tmp_path):
    film = Film(tmp_path)
    film.add(grey(100))
    film.close()
    assert cv2.imread(str(tmp_path / "strip.png")).shape == (300, 1600, 3)


def test_a_run_without_pictures_leaves_an_empty_folder(tmp_path):
    Film(tmp_path).close()
    assert list(tmp_path.iterdir()) == []


def test_pictures_are_never_written_over(tmp_path):
    (tmp_path / "0001.jpg").touch()
    with pytest.raises(FilmError, match=r"holds 0001\.jpg already; name an empty folder"):
        Film(tmp_path)


def test_a_folder_that_cannot_be_made_is_reported(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FilmError, match="cannot be written to"):
        Film(tmp_path / "file" / "run")


def test_a_full_disk_is_reported(tmp_path, full_disk):
    film = Film(tmp_path)
    film.add(grey(100))
    with full_disk():
        with pytest.raises(FilmError, match=r"0002\.jpg cannot be written: "):
            film.add(grey(100))
        with pytest.raises(FilmError, match=r"strip\.png cannot be written: "):
            film.close()
