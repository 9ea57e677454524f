"""What the file of a robot's drivers says is what skills use, and what is wrong is said at once."""

from pathlib import Path

import pytest
import yaml

from remodel_skills.edge.robot_file import RobotFileError, read_robot

FOLDER = Path(__file__).parents[2] / "config/robots"
SHIPPED = sorted(file.stem for file in FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_file_names_drivers_for_each_robot_of_its_cell(name):
    topics = read_robot(name)
    assert set(topics.robots) == {robot.name for robot in topics.design.robots}
    assert topics.tick_s == pytest.approx(1 / 120)


def shipped(name):
    return yaml.safe_load((FOLDER / f"{name}.yaml").read_text())


def changed(tmp_path, change, name="franka_ros"):
    """Return the path of a file that is a shipped one but for a change of what it holds."""
    parsed = shipped(name)
    change(parsed)
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(parsed))
    return str(file)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda p: p.pop("robots"), "missing: robots"),
        (lambda p: p.pop("fixture"), "missing: fixture"),
        (lambda p: p["overhead"].pop("depth"), "overhead: found image; missing: depth"),
        (lambda p: p.update(robot="x"), "found robot; allowed: cell, tick_hz, robots"),
        (
            lambda p: p["robots"]["robot_1"]["motion"].update(type="std_msgs/Float64"),
            "robots.robot_1.motion.type: found 'std_msgs/Float64'; allowed: geometry_msgs/Pose",
        ),
        (
            lambda p: p["robots"]["robot_1"]["wrench"].update(sign=0),
            "robots.robot_1.wrench.sign: found 0; allowed: 1, -1",
        ),
        (
            lambda p: p["robots"]["robot_1"].update(hand_mass=float("nan")),
            "robots.robot_1.hand_mass",
        ),
        (
            lambda p: p["robots"]["robot_1"]["joint_states"]["joints"].pop(),
            "robots.robot_1.joint_states.joints: found 6 names; the arm of cell one_panda has 7",
        ),
        (
            lambda p: p["robots"].update(left=p["robots"].pop("robot_1")),
            "robots: found left; cell one_panda has robot_1",
        ),
        (
            lambda p: p.update(also_overhead=[p["overhead"]]),
            "overhead, also_overhead: found 2 cameras; cell one_panda has 1 above the board",
        ),
    ],
)
def test_what_is_wrong_in_a_file_is_named_with_what_is_allowed(tmp_path, change, says):
    with pytest.raises(RobotFileError) as error:
        read_robot(changed(tmp_path, change))
    assert says in str(error.value)
    assert "mine.yaml" in str(error.value)


def test_every_camera_above_the_board_of_a_large_cell_has_its_topics(tmp_path):
    more = [
        {"image": f"/overhead_{n}/image_raw", "depth": f"/overhead_{n}/depth/image_raw"}
        for n in range(2, 7)
    ]
    cell = {"cell": "large_cabinet", "also_overhead": more}
    file = changed(tmp_path, lambda p: p.update(cell), "simulated_cabinet")
    all_of_them = [shipped("simulated_cabinet")["overhead"], *more]
    found = [each.image for each in read_robot(file).overheads]
    assert found == [each["image"] for each in all_of_them]


def test_a_camera_that_measures_depth_in_the_cell_has_its_topic_in_the_file(tmp_path):
    def without_depth(parsed):
        del parsed["robots"]["robot_1"]["camera"]["depth"]

    file = changed(tmp_path, without_depth, "simulated_cabinet")
    with pytest.raises(RobotFileError, match=r"robot_1\.camera: found no depth; the camera"):
        read_robot(file)


def test_a_name_that_is_no_robot_is_answered_with_those_that_are():
    with pytest.raises(RobotFileError, match=f"there are: {', '.join(SHIPPED)}"):
        read_robot("fanuc")


def test_a_cell_file_beside_the_robot_file_is_taken(tmp_path):
    cells = Path(__file__).parents[3] / "remodel_work/config/cells"
    own = (cells / "one_panda.yaml").read_text().replace("name: one_panda", "name: mine", 1)
    (tmp_path / "my_cell.yaml").write_text(own)
    file = changed(tmp_path, lambda p: p.update(cell="my_cell.yaml"))
    assert read_robot(file).design.name == "mine"
