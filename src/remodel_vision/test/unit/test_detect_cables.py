"""The command detect_cables: what it prints, draws and refuses."""

import json

import cv2
import numpy as np
import pytest

from remodel_vision.commands.detect_cables import main


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


def test_colours_widths_a_mask_and_a_background_limit_what_is_found(photograph, tmp_path, capsys):
    def found(*options):
        main([str(photograph), "--json", *options])
        return len(json.loads(capsys.readouterr().out)["cables"])

    empty, black = tmp_path / "empty.png", tmp_path / "black.png"
    cv2.imwrite(str(empty), np.full((240, 320, 3), 160, np.uint8))
    cv2.imwrite(str(black), np.zeros((240, 320, 3), np.uint8))
    assert found("--colour", "200,40,40", "--width", "8", "--background", str(empty)) == 1
    assert found("--colour", "40,40,200") == 0
    assert found("--width", "20") == 0
    assert found("--mask", str(black)) == 0
    assert found("--background", str(photograph)) == 0


def test_a_colour_that_is_none_is_refused(photograph, capsys):
    with pytest.raises(SystemExit):
        main([str(photograph), "--colour", "red"])
    assert "write red, green and blue" in capsys.readouterr().err


def test_a_drawing_is_written(photograph, tmp_path, capsys):
    drawn = tmp_path / "drawn.png"
    assert main([str(photograph), "--draw", str(drawn)]) == 0
    assert cv2.imread(str(drawn)).shape == (240, 320, 3)
    assert "1 cable, 0 crossings" in capsys.readouterr().out


def test_a_result_with_warnings_ends_with_one(tmp_path, capsys):
    empty = tmp_path / "empty.png"
    cv2.imwrite(str(empty), np.full((240, 320, 3), 160, np.uint8))
    assert main([str(empty)]) == 1
    assert "warning: nothing in the picture looks like a cable" in capsys.readouterr().out
    assert main([str(empty), "--json"]) == 1
    (warning,) = json.loads(capsys.readouterr().out)["warnings"]
    assert "nothing in the picture looks like a cable" in warning


@pytest.mark.parametrize("name", ["absent.png", "text.png", "empty.png", "tiny.png", "."])
def test_what_is_no_picture_is_refused(name, tmp_path, capsys):
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "empty.png").touch()
    cv2.imwrite(str(tmp_path / "tiny.png"), np.zeros((9, 9, 3), np.uint8))
    assert main([str(tmp_path / name)]) == 2
    assert str(tmp_path / name) in capsys.readouterr().err


@pytest.mark.parametrize("ending", ["jpg", "png", "bmp", "tif", "webp"])
@pytest.mark.parametrize("part", [0.5, 0.97])
def test_a_part_of_a_picture_is_refused(ending, part, photograph, tmp_path, capsys):
    cut = tmp_path / f"cut.{ending}"
    cv2.imwrite(str(cut), cv2.imread(str(photograph)))
    assert main([str(cut)]) == 0
    data = cut.read_bytes()
    cut.write_bytes(data[: int(part * len(data))])
    assert main([str(cut)]) == 2
    assert str(cut) in capsys.readouterr().err


def test_a_picture_is_turned_as_its_camera_says(photograph, tmp_path, capsys):
    turned = tmp_path / "turned.jpg"
    cv2.imwrite(str(turned), cv2.imread(str(photograph)))
    data = turned.read_bytes()
    # A segment APP1 of EXIF data that holds the orientation alone: 6, "turn it to the right".
    exif = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
    segment = b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif
    turned.write_bytes(data[:2] + segment + data[2:])
    assert main([str(turned), "--json"]) == 0
    (cable,) = json.loads(capsys.readouterr().out)["cables"]
    ends = sorted(tip["point"] for tip in cable["tips"])
    assert np.allclose(ends, [[69, 250], [159, 60]], atol=5), "(x, y) became (239 - y, x)"


@pytest.mark.parametrize("kind", ["grey", "transparent", "deep"])
def test_pictures_of_all_kinds_are_read(kind, photograph, tmp_path, capsys):
    bgr = cv2.imread(str(photograph))
    pictures = {
        "grey": cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY),
        "transparent": cv2.cvtColor(bgr, cv2.COLOR_BGR2BGRA),
        "deep": bgr.astype(np.uint16) * 257,
    }
    path = tmp_path / f"{kind}.png"
    cv2.imwrite(str(path), pictures[kind])
    assert main([str(path)]) == 0
    assert "1 cable, 0 crossings" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["absent/drawn.png", "drawn.unknown"])
def test_a_drawing_that_cannot_be_written_is_refused(name, photograph, tmp_path, capsys):
    assert main([str(photograph), "--draw", str(tmp_path / name)]) == 2
    assert name in capsys.readouterr().err
