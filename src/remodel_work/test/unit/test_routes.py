"""Clips and ducts on a path, and slots of ducts before terminals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from formboards import along_clips, duct, formboard
from panels import panel

from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, Duct
from remodel_work.routes import clips_along, places_in, slot_before, world_from_clip


def path(*points):
    return tuple(BOARD @ Pose.level(x, y, 0.04, 0.0) for x, y in points)


def test_the_clips_on_a_path_come_in_its_order():
    board = formboard(3)
    there = along_clips(board)
    assert [clip.id for clip in clips_along(there, board)] == ["C1", "C2", "C3"]
    assert [clip.id for clip in clips_along(there[::-1], board)] == ["C3", "C2", "C1"]


def test_a_path_from_clip_to_clip_passes_each_of_them_once():
    board = formboard(6)
    poses = [world_from_clip(clip, board) for clip in board.clips]
    ends = along_clips(board)
    found = clips_along((ends[0], *poses, ends[1]), board)
    assert [clip.id for clip in found] == ["C1", "C2", "C3", "C4", "C5", "C6"]


def test_a_clip_points_along_the_path():
    board = formboard(1)
    (clip,) = clips_along(along_clips(board)[::-1], board)
    assert math.cos(clip.pose[2] + math.pi / 2) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "points",
    [
        ((-0.028, -0.2), (-0.028, 0.2)),
        ((-0.1, -0.1), (0.1, -0.1)),
        ((-0.04, 0.0), (-0.04, 0.1)),
        ((-0.04, -0.1), (-0.04, -0.1)),
        ((-0.04, 0.3),),
    ],
)
def test_a_clip_beside_across_or_behind_a_path_is_not_on_it(points):
    assert clips_along(path(*points), formboard(2)) == ()


def test_a_path_is_checked_where_it_runs_in_a_duct():
    trough, board = duct(0.0, 0.0, length=0.12), formboard(2)
    places = places_in(trough, path((0.0, -0.2), (0.005, 0.02)), board)
    ys = [place.position[1] for place in places]
    assert np.allclose(ys, [-0.05, -0.03, -0.01, 0.01])
    assert places_in(trough, path((-0.2, 0.0), (0.2, 0.0)), board) == (), "it only crosses it"
    assert places_in(trough, path((0.05, -0.2), (0.05, 0.2)), board) == ()


# Along y; its wall at x 0.02 has slots at y 0, 12.5 mm, ...
DUCT = Duct("D1", (0.0, 0.0, math.pi / 2), 0.40, 0.040, 0.060, slot_pitch=0.0125, slot_width=0.007)


def board(*ducts):
    return replace(panel(), ducts=ducts)


@pytest.mark.parametrize(("y", "aside"), [(0.0, 0.0), (0.004, 0.004), (0.010, -0.0025)])
def test_the_nearest_slot_is_found_beside_the_axis(y, aside):
    # The opening's y axis points against the panel's: its x, into the terminal, is the panel's.
    opening = Pose.level(0.065, y, 0.023)
    slot = slot_before(board(DUCT), opening)
    assert slot.before == pytest.approx(0.045)
    assert slot.aside == pytest.approx(-aside)


def test_a_wire_from_the_slot_points_at_the_opening():
    opening = Pose.level(0.065, 0.004, 0.023)
    slot = slot_before(board(DUCT), opening)
    at_slot = opening.apply([-slot.before, slot.aside, 0.0])
    towards = opening.position - at_slot
    assert math.atan2(towards[1], towards[0]) == pytest.approx(opening.yaw + slot.slant)


@pytest.mark.parametrize(
    ("opening", "duct"),
    [
        (Pose.level(0.065, 0.0, 0.023), replace(DUCT, slot_pitch=0.0)),  # solid walls
        (Pose.level(0.065, 0.0, 0.023, math.pi), DUCT),  # it looks the other way
        (Pose.level(0.065, 0.0, 0.023, math.pi / 2), DUCT),  # along the wall
        (Pose.level(0.165, 0.0, 0.023), DUCT),  # the wall is far
        (Pose.level(0.065, 0.3, 0.023), DUCT),  # beyond its end
    ],
)
def test_no_slot_stands_before_other_openings(opening, duct):
    assert slot_before(board(duct), opening) is None
