"""Robots and their meshes, as the page draws them; no ROS."""

import struct

import pytest

from remodel_console.core.cell import Joint, Shape, read_robot
from remodel_console.core.record import wire_words
from remodel_console.core.use_case import Failure, Task, UseCase
from remodel_console.edge.kept_files import stl_of
from remodel_run.progress import Phase, TaskPhase

URDF = """<robot name="r">
<link name="base">
  <visual><geometry><mesh filename="/fine.obj"/></geometry></visual>
  <collision><geometry><mesh filename="/coarse.obj" scale="2 2 2"/></geometry></collision>
</link>
<link name="tip"><visual><origin xyz="0 0 1" rpy="0 0 3.14159265"/>
  <geometry><box size="1 2 3"/></geometry>
  <material name="m"><color rgba="1 0 0.5 1"/></material></visual>
  <collision><geometry><box size="9 9 9"/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="base"/><child link="tip"/>
  <axis xyz="0 1 0"/></joint>
</robot>"""


def test_a_link_is_drawn_by_its_boxes_and_its_coarse_meshes():
    robot = read_robot(URDF)
    assert robot.root == "base"
    assert robot.meshes == ("/coarse.obj",)
    still = (0.0, 0.0, 0.0, 1.0)
    mesh = Shape((0.0, 0.0, 0.0), still, "#d4d7db", (2.0, 2.0, 2.0), "/coarse.obj")
    assert robot.shapes["base"] == (mesh,)
    (box,) = robot.shapes["tip"]
    assert (box.position, box.size, box.colour) == ((0, 0, 1), (1, 2, 3), "#ff0080")
    assert box.rotation == pytest.approx((0, 0, 1, 0), abs=1e-6)
    joint = Joint("j", "revolute", "base", "tip", (0.0, 0.0, 0.0), still, axis=(0.0, 1.0, 0.0))
    assert robot.joints == (joint,)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("no XML", "no URDF"),
        ("<robot><link/></robot>", "no URDF"),
        ('<robot><link name="a"/><link name="b"/></robot>', r"root links \['a', 'b'\]"),
        ('<robot><link name="a"/><joint name="j" type="fixed"/></robot>', "no URDF"),
    ],
)
def test_what_is_no_robot_is_refused(text, reason):
    with pytest.raises(ValueError, match=reason):
        read_robot(text)


def test_an_obj_file_becomes_stl_with_its_faces_cut_to_triangles(tmp_path):
    file = tmp_path / "square.obj"
    file.write_text(
        "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 -1\n"
    )
    data = stl_of(str(file))
    assert struct.unpack_from("<I", data, 80) == (2,)
    assert len(data) == 84 + 2 * 50
    assert struct.unpack_from("<9f", data, 84 + 12) == (0, 0, 0, 1, 0, 0, 1, 1, 0)
    assert struct.unpack_from("<9f", data, 84 + 50 + 12) == (0, 0, 0, 1, 1, 0, 0, 1, 0)


@pytest.mark.parametrize(("name", "text"), [("a.obj", "f 1 2 3"), ("a.dae", "<x/>")])
def test_a_mesh_that_cannot_be_drawn_is_refused(tmp_path, name, text):
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(ValueError, match=name):
        stl_of(str(file))


def test_a_wire_is_known_by_its_task_and_what_failed():
    task = Task("W4", "K1/A2 to X1/2", TaskPhase.RUNNING, 2, False, 80.0, 30.0)
    failures = (
        Failure(1.0, "W4", "grasp_missed", 205, "PickCable", "nothing held", "retry", ""),
        Failure(2.0, "W5", "grasp_missed", 205, "PickCable", "of another", "retry", ""),
        Failure(3.0, "W4", "insertion_jammed", 303, "InsertCable", "22 N", "ask_operator", ""),
    )
    use_case = UseCase(Phase.ASKING, tasks=(task,), failures=failures)
    assert wire_words("W4", use_case) == (
        "K1/A2 to X1/2",
        "running, 2 attempts, 80 s",
        "Insertion jammed: 22 N; the cell asks you.",
        "Grasp missed: nothing held; the cell tries again.",
    )
    assert wire_words("W9", use_case) == ("No task of the present order is about this wire.",)
    assert wire_words("W9", None) == wire_words("W9", use_case)
