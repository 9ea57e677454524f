"""The numbers of the skills: read from files, checked, and replaced by a user's own."""

from dataclasses import replace

import pytest
from scripted_device import SOCKET, TERMINAL, WIRE, before_the_opening

from remodel_skills.commands.parameters import main
from remodel_skills.edge.parameter_files import ParameterError, parameters_with, read_parameters
from remodel_skills.primitives.pushing import push_in, tool_before
from remodel_skills.robot_context import run
from remodel_work.layout import STANDOFF_M

SHIPPED = read_parameters()
GOOD = "free_speed_m_s: {value: 0.5, unit: m/s, origin: measured on our robot}"


def own(folder, text, file="motion.yaml"):
    (folder / file).write_text(text)
    return str(folder)


def test_each_number_of_the_package_says_what_it_is_and_where_it_is_from():
    silent = [each.name for each in SHIPPED.table if not (each.meaning and each.origin)]
    assert silent == []
    assert SHIPPED.parameters.motion.free_speed_m_s == 0.9


def test_a_users_file_replaces_single_numbers_only(tmp_path):
    with_own = parameters_with(own(tmp_path, GOOD))
    assert with_own.parameters.motion.free_speed_m_s == 0.5
    changed = [
        (mine.name, mine.is_own)
        for mine, theirs in zip(with_own.table, SHIPPED.table, strict=True)
        if mine != theirs
    ]
    assert changed == [("motion.free_speed_m_s", True)]


def test_an_angle_may_be_given_in_degrees_and_in_radians(tmp_path):
    text = "most_aside_rad: {value: 1.5, unit: rad, origin: a test}\n"
    assert parameters_with(own(tmp_path, text)).parameters.motion.most_aside_rad == 1.5
    assert SHIPPED.parameters.motion.most_aside_rad == pytest.approx(1.9199, abs=1e-4)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("fre_speed_m_s: {value: 0.5, unit: m/s, origin: x}", "is no parameter; .*free_speed_m_s"),
        (GOOD.replace("m/s,", "mm/s,"), "is in 'mm/s'; allowed: m/s"),
        (GOOD.replace("0.5", "3.0"), "is 3 m/s; allowed: 0.0001 to 2 m/s"),
        (GOOD.replace("0.5", "0"), "is 0 m/s; allowed: 0.0001 to 2"),
        (GOOD.replace("0.5", ".nan"), "is nan; allowed: a number"),
        (GOOD.replace("0.5", "fast"), "is 'fast'; allowed: a number"),
        (GOOD.replace("0.5", "5e-1"), "is '5e-1'; allowed: a number .*write 6.0e[+]4"),
        (GOOD.replace("0.5", "true"), "is True; allowed: a number"),
        (GOOD.replace("0.5", "[0.5]"), r"is \[0.5\]; allowed: a number"),
        ("tucks: {value: 2.5, unit: 1, origin: x}", "is 2.5; allowed: a whole number"),
        ("hold_z_m: {value: [0.1], unit: m, origin: x}", "allowed: a list of 2 numbers"),
        ("around_m: {value: [], unit: m, origin: x}", "allowed: a list of numbers"),
        ("most_aside_rad: {value: 190, unit: deg, origin: x}", "allowed: 0 to 180 deg"),
        ("free_speed_m_s: {value: 0.5, unit: m/s}", "it needs value, unit, origin"),
        ("free_speed_m_s: 0.5", "is 0.5; it needs value, unit, origin"),
        (GOOD.replace("origin", "allowed: [0, 9], origin"), "has 'allowed'; allowed: meaning,"),
    ],
)
def test_a_wrong_entry_is_refused_with_its_file_and_line(tmp_path, text, words):
    folder = own(tmp_path, f"# ours\n{text}\n")
    with pytest.raises(ParameterError, match=words) as caught:
        parameters_with(folder)
    (problem,) = caught.value.problems
    assert problem.startswith(f"{folder}/motion.yaml:2: motion.")


def test_all_wrong_entries_are_reported_at_once(tmp_path):
    text = f"{GOOD.replace('0.5', '3.0')}\ntucks: {{value: -1, unit: 1, origin: x}}\n"
    with pytest.raises(ParameterError, match="2 problems"):
        parameters_with(own(tmp_path, text))


@pytest.mark.parametrize(
    ("file", "text", "words"),
    [
        ("motion.yaml", f"{GOOD}\n{GOOD}", "motion.yaml:2: .*stands in line 1, too"),
        ("motion.yaml", "free_speed_m_s: {", "cannot be read"),
        ("motion.yaml", "- 1", "holds no parameters"),
        ("motions.yaml", GOOD, "is no file of parameters; allowed: tool.yaml, wire.yaml"),
        ("motion.txt", GOOD, "which has no file; allowed: tool.yaml"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path, file, text, words):
    with pytest.raises(ParameterError, match=words):
        parameters_with(own(tmp_path, text, file))


def test_the_command_prints_what_is_in_force_and_where_it_stands(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REMODEL_SKILLS", own(tmp_path, GOOD))
    assert main(["motion.free"]) == 0
    line = capsys.readouterr().out
    assert line.split()[:4] == [
        *("motion.free_speed_m_s", "0.5", "m/s"),
        f"{tmp_path}/motion.yaml:1",
    ]
    assert "of an empty hand, high up; origin: measured on our robot" in line
    assert main([]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(SHIPPED.table)


def test_the_command_reports_a_wrong_file(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REMODEL_SKILLS", own(tmp_path, "tuks: 1"))
    assert main([]) == 1
    assert "motion.tuks is no parameter; there are: tucks" in capsys.readouterr().err


def test_a_skill_does_as_the_parameters_in_force_say(tmp_path):
    text = "overtravel_m: {value: 0.002, unit: m, origin: a test}"
    context, arm = before_the_opening(lambda depth: 0.0)
    context.parameters = parameters_with(own(tmp_path, text, "terminal.yaml")).parameters
    context.drive(tool_before(SOCKET, context.belief.grip, -STANDOFF_M))
    push = run(arm.tick, push_in(context, SOCKET, TERMINAL.depth, limit=8.0))
    assert push.depth == pytest.approx(TERMINAL.depth + 0.002, abs=1e-3)


def test_the_thinner_a_wire_the_less_it_is_pushed_against_a_face():
    wires, thin = SHIPPED.parameters.wire, replace(WIRE, bending_stiffness=0.25e-3)
    assert wires.most_at_face_n(WIRE) == wires.gentle_above_n == 10.0
    assert wires.most_at_face_n(thin) == pytest.approx(2.5, abs=0.05)
    soft = replace(thin, yield_curvature=thin.yield_curvature / 2)
    assert wires.most_at_face_n(soft) == pytest.approx(wires.most_at_face_n(thin) / 2)
    long = replace(thin, ferrule_length=2 * thin.ferrule_length)
    assert wires.most_at_face_n(long) == pytest.approx(wires.most_at_face_n(thin) / 2)


def test_a_stiff_wire_pulls_more_before_it_counts_as_snagged():
    wires = SHIPPED.parameters.wire
    free = [wires.snagged_n(stiffness) - wires.snag_n for stiffness in (1e-3, 2e-3)]
    assert free == pytest.approx([2.5, 5.0])
