"""Cable detection on drawn pictures; benchmarks/vision measures it on rendered ones."""

import itertools
import math

import cv2
import numpy as np
import pytest

from remodel_vision.cables import CableEnding, detect_cables
from remodel_vision.cables.lines import arc_lengths, at_distance, basis, fit
from remodel_vision.cables.network import StrandEnd, best_pairs, find_strands, join_prices, thin
from remodel_vision.cables.warnings import evidence_warnings

RED, BLUE, TABLE = (190, 30, 30), (30, 60, 190), (150, 140, 120)


def table():
    grain = np.random.default_rng(3).normal(0, 3, (480, 640, 3))
    return np.clip(np.array(TABLE) + grain, 0, 255).astype(np.uint8)


def lay(picture, points, colour=RED, width=8):
    """Draw a cable (n, 2) with square ends, four times finer than the picture."""
    fine = np.zeros((480 * 4, 640 * 4), np.uint8)
    for a, b in itertools.pairwise(points):
        along = (b - a) / np.linalg.norm(b - a)
        side = np.array([-along[1], along[0]]) * width / 2
        quad = (np.array([a + side, b + side, b - side, a - side]) * 4 + 1.5) * 16
        cv2.fillConvexPoly(fine, np.rint(quad).astype(np.int32), 255, cv2.LINE_8, 4)
    cover = cv2.resize(fine, (640, 480), interpolation=cv2.INTER_AREA)[..., None] / 255
    picture[:] = np.rint(picture * (1 - cover) + np.array(colour) * cover).astype(np.uint8)


def wave(start, end, height, count=200):
    u = np.linspace(0, 1, count)[:, None]
    line = np.array(start) + u * (np.array(end) - np.array(start))
    way = (np.array(end) - start) / np.linalg.norm(np.array(end) - start)
    return line + height * np.sin(2 * np.pi * u) * np.array([-way[1], way[0]])


def errors(found, true):
    return np.linalg.norm(found[:, None] - true[None], axis=-1).min(axis=1)


def test_a_cable_is_found_with_its_tips_and_width():
    picture, true = table(), wave((80, 120), (560, 330), 60, 2000)
    lay(picture, true)
    found = detect_cables(picture)
    (cable,) = found.cables
    assert errors(cable.centreline, true).mean() < 0.2
    tips = np.array([tip.point for tip in cable.tips])
    assert errors(true[[0, -1]], tips).max() < 0.6
    assert [tip.end for tip in cable.tips] == [CableEnding.TIP, CableEnding.TIP]
    assert cable.width == pytest.approx(8, abs=0.4)
    assert found.warnings == ()


def test_cables_on_a_jpeg_whose_black_table_is_cut_off_are_found_without_a_warning():
    dark = np.random.default_rng(5).normal(-1, 1.2, (480, 640, 3))
    picture = np.clip(dark, 0, 255).astype(np.uint8)
    first, second = wave((60, 240), (580, 240), 50, 2000), wave((320, 40), (300, 440), 20, 2000)
    lay(picture, first, (190, 80, 90))
    lay(picture, second, (150, 170, 60))
    _, data = cv2.imencode(".jpg", cv2.GaussianBlur(picture, (0, 0), 0.8))
    found = detect_cables(cv2.imdecode(data, cv2.IMREAD_COLOR))
    assert found.warnings == ()
    assert len(found.crossings) == 1
    for cable, true in zip(found.cables, (first, second), strict=True):
        assert errors(cable.centreline, true).mean() < 0.5
        assert cable.width == pytest.approx(8, abs=1)


def test_a_picture_with_one_cable_on_black_is_not_dark():
    picture = np.zeros((480, 640, 3), np.uint8)
    lay(picture, wave((100, 240), (540, 240), 50, 2000), (190, 80, 90))
    assert (picture.max(axis=2) >= 75).mean() < 0.02
    assert detect_cables(picture).warnings == ()
    assert "the picture is dark" in detect_cables(picture // 4).warnings[0]


def test_two_cables_of_one_colour_that_cross_stay_two():
    picture = table()
    lay(picture, wave((60, 240), (580, 240), 50))
    lay(picture, wave((320, 40), (300, 440), 20))
    found = detect_cables(picture)
    assert len(found.cables) == 2
    (crossing,) = found.crossings
    assert {crossing.upper, crossing.lower} == {0, 1}


def test_the_upper_cable_is_recognised_by_its_colour():
    picture = table()
    lay(picture, wave((60, 240), (580, 250), 5), BLUE)
    lay(picture, wave((330, 60), (300, 430), 5), RED)
    found = detect_cables(picture)
    (crossing,) = found.crossings
    assert found.cables[crossing.upper].colour[0] > 150, "the red one was drawn last"
    assert crossing.confidence > 0.9


@pytest.mark.parametrize("first_below", [True, False])
def test_the_upper_cable_of_one_colour_is_recognised_by_its_highlight(first_below):
    picture = table()
    lines = [wave((60, 240), (580, 250), 5), wave((330, 60), (300, 430), 5)]
    for line in lines if first_below else lines[::-1]:
        lay(picture, line)
        lay(picture, line, (240, 150, 150), 2)
    (crossing,) = (found := detect_cables(picture)).crossings
    tips = [tip.point for tip in found.cables[crossing.upper].tips]
    assert (abs(tips[0][1] - tips[1][1]) > 300) == first_below
    assert crossing.confidence > 0.9


def test_which_of_two_flat_strands_of_one_colour_is_on_top_is_not_claimed():
    picture = table()
    lay(picture, wave((60, 240), (580, 250), 5))
    lay(picture, wave((330, 60), (300, 430), 5))
    (crossing,) = detect_cables(picture).crossings
    assert crossing.confidence < 0.5


def test_a_loop_is_one_cable_that_crosses_itself():
    angle = np.linspace(-0.75 * math.pi, 1.25 * math.pi + 0.5 * math.pi, 600)
    spiral = np.column_stack([320 + 2.2 * np.degrees(angle) / 3, np.zeros(600)])
    spiral += 90 * np.column_stack([np.cos(angle), np.sin(angle)]) + [0, 240]
    picture = table()
    lay(picture, spiral)
    found = detect_cables(picture)
    assert len(found.cables) == 1
    (crossing,) = found.crossings
    assert crossing.upper == crossing.lower == 0


def test_a_cable_that_leaves_the_picture_is_truncated_there():
    picture = table()
    lay(picture, wave((-30, 200), (400, 300), 20))
    (cable,) = detect_cables(picture).cables
    ends = {tip.end: tip.point for tip in cable.tips}
    assert ends[CableEnding.TRUNCATED][0] < 3
    assert np.linalg.norm(ends[CableEnding.TIP] - [400, 300]) < 1


def test_a_cable_under_a_card_of_another_colour_is_one():
    picture = table()
    lay(picture, wave((80, 240), (560, 240), 30))
    picture[180:300, 300:330] = (20, 90, 40)
    found = detect_cables(picture)
    assert len([c for c in found.cables if c.colour[0] > 150]) == 1


def test_an_empty_table_has_no_cables_and_says_so():
    found = detect_cables(table())
    assert found.cables == ()
    assert found.warnings


def test_only_cables_of_a_known_colour_are_found():
    picture, true = table(), wave((330, 60), (300, 430), 5, 2000)
    lay(picture, wave((60, 240), (580, 250), 5), RED)
    lay(picture, true, BLUE)
    (cable,) = detect_cables(picture, colours=[BLUE]).cables
    assert errors(cable.centreline, true).mean() < 0.5
    assert errors(true[[0, -1]], cable.centreline).max() < 2


def test_only_cables_of_a_known_width_are_found():
    picture = table()
    lay(picture, wave((60, 150), (580, 150), 20), RED, width=6)
    lay(picture, wave((60, 330), (580, 330), 20), BLUE, width=12)
    (cable,) = detect_cables(picture, widths=[12]).cables
    assert cable.width == pytest.approx(12, abs=1)


def test_no_cable_is_found_where_the_mask_is_black():
    picture, mask = table(), np.zeros((480, 640), np.uint8)
    lay(picture, wave((60, 150), (580, 150), 20))
    lay(picture, wave((60, 330), (580, 330), 20))
    mask[:240] = 255
    (cable,) = detect_cables(picture, mask=mask).cables
    assert cable.centreline[:, 1].max() < 240


def test_what_the_background_shows_is_no_cable():
    background = table()
    background[100:110] = (90, 90, 95)
    background[:, 500:512] = (40, 90, 60)
    noise = np.random.default_rng(8).normal(0, 2, background.shape)
    picture = np.clip(background + noise, 0, 255).astype(np.uint8)
    lay(picture, wave((80, 60), (560, 400), 60))
    assert len(detect_cables(picture).cables) > 1
    found = detect_cables(picture, background=background)
    assert len(found.cables) == 1
    assert found.warnings == ()


@pytest.mark.parametrize(
    ("prior", "why"),
    [
        ({"mask": np.ones((48, 64), np.uint8)}, r"a mask of shape \(48, 64\)"),
        ({"background": np.ones((48, 64, 3), np.uint8)}, r"a background of shape \(48, 64, 3\)"),
        ({"colours": [(300, 0, 0)]}, "red, green, blue from 0 to 255"),
        ({"colours": [(30, 0)]}, "red, green, blue from 0 to 255"),
        ({"widths": [0]}, "width 0; it must be above 0"),
        ({"widths": [math.nan]}, "width nan"),
    ],
)
def test_prior_knowledge_that_does_not_fit_the_picture_is_refused(prior, why):
    with pytest.raises(ValueError, match=why):
        detect_cables(table(), **prior)


def test_a_warning_about_one_cable_leaves_the_others_without():
    picture = table()
    lay(picture, wave((-30, 100), (700, 100), 0), BLUE)
    lay(picture, wave((80, 330), (560, 330), 40), RED)
    found = detect_cables(picture)
    own = {cable.colour[0] > 150: cable.warnings for cable in found.cables}
    assert "straight from border to border" in own[False][0]
    assert own[True] == ()
    assert set(found.warnings) == set(own[False])


def test_stripes_of_a_table_cause_a_warning():
    stripes = np.tile(np.arange(640) // 6 % 2 * 200, (480, 1)).astype(np.uint8)
    found = detect_cables(np.dstack([stripes] * 3))
    assert "straight from border to border" in " ".join(found.warnings)


def test_a_table_full_of_objects_is_too_cluttered():
    picture = table()
    for x, y in itertools.product(range(8, 640, 24), range(8, 480, 24)):
        cv2.line(picture, (x, y), (x + 10, y + 10), RED, 3)
    found = detect_cables(picture)
    assert "too cluttered" in found.warnings[0]
    assert all(cable.warnings for cable in found.cables)


def test_cables_on_coloured_sheets_are_found_with_a_warning():
    picture = table()
    picture[:, 300:] = (40, 90, 60)
    picture[260:, 80:420] = (90, 60, 130)
    snake = [(x, 200 + 70 * math.sin(x / 70)) for x in range(40, 600, 4)]
    cv2.polylines(picture, [np.int32(snake)], False, (230, 120, 20), 8, cv2.LINE_AA)
    found = detect_cables(picture)
    (cable,) = (cable for cable in found.cables if cable.confidence > 0.5)
    ends = sorted(tip.point[0] for tip in cable.tips)
    assert ends == pytest.approx([40, 596], abs=6)


def test_a_shadow_that_prolongs_a_cable_causes_a_warning():
    picture = table()
    shadow = (picture[0, 0] * 0.45).astype(np.uint8).tolist()
    cv2.line(picture, (100, 240), (440, 240), shadow, 8, cv2.LINE_AA)
    cv2.line(picture, (100, 240), (410, 240), RED, 8, cv2.LINE_AA)
    found = detect_cables(picture)
    tips = [tip.point[0] for cable in found.cables for tip in cable.tips]
    assert max(tips, default=0.0) < 415 or found.warnings


def test_a_ferrule_of_another_colour_causes_a_warning():
    picture, tip = table(), np.array([500.0, 250.0])
    lay(picture, np.array([[120.0, 200.0], tip]), BLUE)
    lay(picture, np.array([tip, tip + np.array([22.0, 2.9])]), (215, 30, 190), 6)
    assert any("may go on beyond (500, 250)" in w for w in detect_cables(picture).warnings)


def test_a_noisy_picture_causes_a_warning():
    picture = table()
    cv2.line(picture, (100, 240), (540, 240), RED, 6, cv2.LINE_AA)
    assert detect_cables(picture).warnings == ()
    noise = np.random.default_rng(1).normal(0, 25, picture.shape)
    noisy = np.clip(picture + noise, 0, 255).astype(np.uint8)
    assert any("noisy" in warning for warning in detect_cables(noisy).warnings)


@pytest.mark.parametrize(
    ("term", "value", "text"),
    [
        ("softness [widths]", 0.9, "blurred"),
        ("spread of the width", 0.1, "varies in width"),
        ("deep shadows", 0.4, "deep shadow"),
        ("margin", 0.2, "another way is nearly as good"),
    ],
)
def test_odd_evidence_causes_a_warning_of_its_cable(term, value, text):
    good = {
        "softness [widths]": 0.4,
        "spread of the width": 0.01,
        "edges that agree": 0.65,
        "deep shadows": 0.0,
        "margin": 0.5,
    }
    (notice,) = evidence_warnings([good, {**good, term: value}])
    assert text in notice.text
    assert notice.cables == (1,)


def test_lines_left_out_cause_a_warning(monkeypatch):
    monkeypatch.setattr("remodel_vision.cables.detect.rate", lambda *_: 0.01)
    picture = table()
    cv2.line(picture, (100, 100), (500, 380), RED, 8, cv2.LINE_AA)
    found = detect_cables(picture)
    assert found.cables == ()
    assert any("lines left out" in warning for warning in found.warnings)
    (line,) = detect_cables(picture, colours=[RED], widths=[8]).cables
    assert line.confidence == 0.01, "what fits what is known is returned all the same"


def test_a_polyline_goes_on_straight_beyond_its_end():
    line = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    point, tangent = at_distance(line, 3.0)
    np.testing.assert_allclose(point, [1.0, 2.0])
    np.testing.assert_allclose(tangent, [0.0, 1.0])


def test_a_spline_keeps_to_points_on_a_circle():
    angle = np.linspace(0, 4, 200)
    circle = 100 * np.column_stack([np.cos(angle), np.sin(angle)])
    spline = fit(circle, np.ones(200), 40.0)
    assert len(spline.t) == len(spline.c_x) + spline.k + 1
    radius = np.linalg.norm(spline.at(np.linspace(0, 1, 77)), axis=1)
    np.testing.assert_allclose(radius, 100, atol=0.1)


def test_the_basis_sums_to_one_everywhere():
    t = np.array([0, 0, 0, 0, 0.2, 0.5, 1, 1, 1, 1])
    np.testing.assert_allclose(basis(t, np.linspace(0, 1, 41)).sum(axis=1), 1)


def test_a_diagonal_line_of_two_pixels_keeps_its_length():
    mask = np.zeros((60, 60), np.uint8)
    for k in range(40):
        mask[10 + k, 10 + k : 12 + k] = 1
    (strand,) = find_strands(thin(mask))
    assert arc_lengths(strand.points)[-1] > 50


def test_strands_of_a_cross_meet_in_the_middle():
    mask = np.zeros((61, 61), np.uint8)
    mask[30, 5:56] = mask[5:56, 30] = 1
    strands = find_strands(mask)
    assert len(strands) == 4
    assert len({node for s in strands for node in s.nodes}) == 5


def strand_end(number, place, heading, colour=(0, 0, 0)):
    return StrandEnd(
        end=(number, 1),
        place=np.array(place, float),
        heading=np.array(heading, float),
        colour=np.array(colour),
        width=4,
    )


def test_strands_go_straight_on_and_keep_their_colour():
    east, west = strand_end(0, (-9, 0), (1, 0)), strand_end(1, (9, 0), (-1, 0))
    north, south = strand_end(2, (0, -9), (0, 1)), strand_end(3, (0, 9), (0, -1))
    pairs, margin = best_pairs([east, west, north, south])
    assert {frozenset(pair) for pair in pairs} == {
        frozenset({east.end, west.end}),
        frozenset({north.end, south.end}),
    }
    assert margin > 0.5
    red = strand_end(4, (9, 0), (-1, 0), (0, 60, 40))
    price = join_prices([east, west, red])
    assert price[0, 1] < 0.01 < price[0, 2]


def test_an_end_beside_a_passing_strand_stays_alone():
    east, west = strand_end(0, (-9, 0), (1, 0)), strand_end(1, (9, 0), (-1, 0))
    pairs, _ = best_pairs([east, west, strand_end(2, (0, -9), (0, 1))])
    assert pairs == [(east.end, west.end)]
