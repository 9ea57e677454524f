"""The command detect_cables: what it prints, draws and refuses."""

import json

import cv2
import numpy as np
import pytest

from remodel_sim.commands.detect_cables import main


@pytest.fixture
def photograph(tmp_path):
    picture = np.full((240, 320, 3), 160, np.uint8)
    cv2.line(picture, (60, 80), (250, 170), (40, 40, 200), 7, cv2.LINE_AA)
    path = tmp_path / "photograph.png"
    cv2.imwrite(str(path), picture)
    return path


def test_json_holds_the_spline_as_fitpack_writes_it(photograph, capsys):
    assert main([str(photograph), "--json"]) == 0
    (cable,) = json.loads(capsys.readouterr().out)["cables"]
    spline = cable["spline"]
    assert spline["k"] == 3
    assert len(spline["t"]) == len(spline["c_x"]) + 4 == len(spline["c_y"]) + 4
    assert 6 < cable["width"] < 10
    assert {tip["end"] for tip in cable["tips"]} == {"tip"}


def test_a_drawing_is_written(photograph, tmp_path, capsys):
    drawn = tmp_path / "drawn.png"
    assert main([str(photograph), "--draw", str(drawn)]) == 0
    assert cv2.imread(str(drawn)).shape == (240, 320, 3)
    assert "1 cables" in capsys.readouterr().out


def test_an_answer_with_doubts_ends_with_one(tmp_path, capsys):
    empty = tmp_path / "empty.png"
    cv2.imwrite(str(empty), np.full((240, 320, 3), 160, np.uint8))
    assert main([str(empty)]) == 1
    assert "nothing in the picture looks like a cable" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["absent.png", "text.png", "tiny.png"])
def test_what_is_no_picture_is_refused(name, tmp_path, capsys):
    (tmp_path / "text.png").write_text("no picture")
    cv2.imwrite(str(tmp_path / "tiny.png"), np.zeros((9, 9, 3), np.uint8))
    assert main([str(tmp_path / name)]) == 2
    assert name in capsys.readouterr().err


@pytest.mark.parametrize("name", ["absent/drawn.png", "drawn.unknown"])
def test_a_drawing_that_cannot_be_written_is_refused(name, photograph, tmp_path, capsys):
    assert main([str(photograph), "--draw", str(tmp_path / name)]) == 2
    assert name in capsys.readouterr().err
