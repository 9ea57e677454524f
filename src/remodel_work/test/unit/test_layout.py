import dataclasses
import math
import re
from functools import partial

import pytest
from panels import component, example, panel, wire, with_first, with_first_terminal

from remodel_work.edge.cell_file import read_cell
from remodel_work.layout import find_problems as problems_of
from remodel_work.panel import Duct, PanelClip

CLIP = PanelClip(
    id="C1",
    pose=(0.0, 0.1, math.pi / 2),
    wire_diameter=0.003,
    height=0.010,
    length=0.008,
    retention_force=5.0,
)
DUCT = Duct(id="D1", pose=(0.0, 0.0, math.pi / 2), length=0.4, width=0.040, height=0.020)


def find_problems(found, **options):
    design = read_cell()
    return problems_of(found, design.arms, design.takes, **options)


def test_good_panels_have_no_problem():
    assert find_problems(panel()) == ()
    assert find_problems(panel(clips=(CLIP,), ducts=(DUCT,))) == ()
    assert find_problems(example("panel")) == ()


def changed(old, **changes):
    return dataclasses.replace(old, **changes)


with_terminal = partial(with_first_terminal, panel())
with_wire = partial(with_first, panel(), "wires")


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (panel(clips=(CLIP, CLIP)), "2 of the clips are called 'C1'"),
        (panel(clips=(changed(CLIP, retention_force=50.0),)), "clip 'C1': retention_force is 50 N"),
        (panel(clips=(changed(CLIP, height=0.002),)), "clip 'C1': height is 0.002 m"),
        (panel(clips=(changed(CLIP, pose=(0.3, 0.0, 0.0)),)), "clip 'C1' reaches beyond the plate"),
        (panel(ducts=(changed(DUCT, width=0.3),)), "duct 'D1': width is 0.3 m"),
        (panel(ducts=(changed(DUCT, length=0.8),)), "duct 'D1' reaches beyond the plate"),
        (with_wire(friction=0.0), "friction is 0"),
        (with_wire(yield_curvature=1.0), "yield_curvature is 1 1/m"),
        (panel(size=(2.0, 0.7, 0.003)), "the plate's size in x is 2 m"),
        (panel(channels=()), "no channel"),
        (with_terminal(insertion_yaw=1.0), "allowed: 0 or pi"),
        (with_terminal(mouth=(0.025, -0.009, 0.040)), "height of the opening"),
        (with_terminal(mouth=(0.020, -0.009, 0.022)), "the side it opens to"),
        (with_terminal(bore=float("nan")), "must be a finite number"),
        (with_terminal(bore=0.0031), "minus diameter"),
        (with_terminal(depth=0.012), "does not hide"),
        (with_terminal(mouth=(0.025, 0.007, 0.022)), "mm apart"),
        (with_wire(colour="XX"), "colour 'XX' is not known; allowed: one of these codes, or"),
        (with_wire(colour="WHXX"), "colour 'WHXX' is not known"),
        (with_wire(length=0.30), "length between these terminals"),
        (with_wire(b_component="Q9"), "which does not exist"),
        (with_wire(b_component="X1", b_terminal="1"), "2 wire ends go to 'X1/1'"),
        (with_wire(id="W2"), "are called 'W2'"),
        (
            panel(components=(*panel().components, component("X5", 1, 0.08, 0.2, side=-1))),
            "marker_id 1",
        ),
        (
            panel(components=(*panel().components, component("X5", 5, 0.08, 0.13, side=-1))),
            "'X2' and 'X5' overlap by",
        ),
        (
            panel(components=(*panel().components, component("X5", 5, 0.03, 0.25, side=-1))),
            "must open at an edge of a channel",
        ),
    ],
)
def test_each_broken_rule_is_named(broken, words):
    assert any(words in problem for problem in find_problems(broken)), find_problems(broken)


HOUSEHOLD = example("household")


def board_problems(broken, arms=None, *, has_magazine=True):
    design = read_cell("cabinet")
    return problems_of(broken, arms or design.arms, design.takes, has_magazine=has_magazine)


with_first_wire = partial(with_first, HOUSEHOLD, "wires")


def with_ducts(**changes):
    return changed(HOUSEHOLD, ducts=tuple(changed(duct, **changes) for duct in HOUSEHOLD.ducts))


def test_the_household_board_fits_the_cell_for_cabinets():
    assert board_problems(HOUSEHOLD) == ()
    (only,) = board_problems(HOUSEHOLD, has_magazine=False)
    assert "no channel" in only


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (with_ducts(slot_width=0.0031), "ducts 'D0', 'L', 'D1' are 3.1 mm wide, 2.0 mm too narrow"),
        (with_ducts(width=0.060), "35 mm from its openings to duct 'D0', 3.0 mm too little"),
        (with_ducts(height=0.080), "duct 'D0': height is 0.08 m, 0.015 m too much"),
        (with_ducts(slot_width=0.0125), "duct 'D0': slot_width is 0.0125 m"),
        (with_first_wire(length=0.7), "0.11 m too short"),
        (with_first_wire(length=3.5), "length is 3.5 m, 0.5 m too much; allowed: 0.48 to 3 m"),
        (with_first_wire(length=0.35), "length is 0.35 m, 0.13 m too little; allowed: 0.48 to 3 m"),
        (with_first_wire(ducts=("D9",)), "passes duct 'D9'; the panel has: D0, D1, D2, L, R"),
        (with_first(HOUSEHOLD, "rails", height=0.020), "rail 'R1': height is 0.02 m"),
    ],
)
def test_what_a_board_has_too_much_of_is_said_with_what_would_change_it(broken, words):
    problems = board_problems(broken)
    assert any(words in problem for problem in problems), problems


def test_terminals_that_no_arm_reaches_are_one_problem_with_the_farthest():
    arm = read_cell("cabinet").arms[0]
    (far,) = board_problems(HOUSEHOLD, [changed(arm, base=(-0.60, 0.0, 0.0, 0.0), axis=None)])
    assert "no arm reaches 104 of 104 terminals: 'D11/T1', " in far
    assert re.search(r"is out of reach by 0\.5\d m towards \+x: a base nearer to it", far), far
    aside = changed(arm, base=(-0.04, 0.90, 0.0, 0.0), axis=None)
    (far,) = board_problems(HOUSEHOLD, [aside])
    assert re.search(r"is out of reach by 0\.\d\d m towards -y: a longer axis", far), far


def test_thick_fingers_need_a_wider_pitch():
    (narrow, low) = sorted(
        problem
        for problem in board_problems(HOUSEHOLD, read_cell().arms)
        if "height is" not in problem or "'D0'" in problem
    )
    assert "for a finger of 11.0 mm between their wires" in narrow
    assert "a pitch of 16 mm, or thinner fingers" in narrow
    assert low.endswith("a lower duct, longer fingers")


def test_a_wire_between_neighbours_may_be_short_but_not_too_short():
    near = wire("W1", ("X1", "1"), ("X3", "1"), 0.40)
    assert find_problems(panel(wires=(near,))) == ()


def test_labels_have_rules_only_where_components_carry_them():
    bare = [dataclasses.replace(c, marker_id=0, marker_size=0.0) for c in panel().components]
    unlabelled = panel(components=tuple(bare))
    assert find_problems(unlabelled, has_labels=False) == ()
    problems = find_problems(unlabelled)
    assert any("have marker_id 0" in problem for problem in problems)
    assert any("marker_size" in problem for problem in problems)


def test_slots_that_are_just_wide_enough_let_a_wire_through():
    # The wire is 1.4 mm thinner, but for rounding.
    board = with_first(with_ducts(slot_width=0.0075), "wires", diameter=0.0061)
    assert not [problem for problem in board_problems(board) if "slots of duct" in problem]
