"""What the launch file offers reaches the cell."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import roslaunch.config
import roslaunch.xmlloader
from panels import panel

from remodel_sim.physics import world
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros import robot_driver, simulated_cell
from remodel_skills.ros import driven_cell
from remodel_skills.ros import node as skills_node
from remodel_states.edge.exported_tables import read_abilities
from remodel_work.edge import bullet

LAUNCH = ElementTree.parse(Path(__file__).parents[2] / "launch/cell.launch").getroot()


# Of roslaunch, not of the node.
RESPAWN = "respawn"
ARGUMENTS = [arg.get("name") for arg in LAUNCH.iter("arg") if arg.get("name") != RESPAWN]


def test_the_node_comes_again_if_that_is_asked_for():
    assert LAUNCH.find("node").get("respawn") == f"$(arg {RESPAWN})"


@pytest.mark.parametrize("name", ARGUMENTS)
def test_each_argument_is_a_parameter_that_the_node_reads(name):
    passed = {param.get("name"): param.get("value") for param in LAUNCH.find("node")}
    assert passed[name] == f"$(arg {name})"
    assert (
        f'"~{name}"'
        in Path(simulated_cell.__file__).read_text() + Path(skills_node.__file__).read_text()
    )


SKILLS = Path(__file__).parents[3] / "remodel_skills"
# The launch files of the drivers and of the skills over them, and what reads their arguments.
OTHERS = [
    (Path(__file__).parents[2] / "launch/robot_driver.launch", [robot_driver]),
    (SKILLS / "launch/abilities.launch", [skills_node, driven_cell]),
]


@pytest.mark.parametrize(("file", "readers"), OTHERS, ids=lambda value: getattr(value, "stem", ""))
def test_each_argument_of_drivers_and_skills_is_a_parameter_that_is_read(file, readers):
    launch = ElementTree.parse(file).getroot()
    passed = {param.get("name"): param.get("value") for param in launch.find("node")}
    arguments = {arg.get("name") for arg in launch.iter("arg")}
    assert passed == {name: f"$(arg {name})" for name in arguments}
    code = "".join(Path(reader.__file__).read_text() for reader in readers)
    assert [name for name in arguments if f'"~{name}"' not in code] == []


@pytest.mark.parametrize(
    ("given", "nodes", "simulated_time"),
    [
        ([], {"cell"}, True),
        (["robot:=franka_ros"], {"abilities"}, None),
        (["robot:=simulated_cabinet", "drivers:=true"], {"abilities", "robot_driver"}, True),
        (["fake:=true"], {"fake_cell"}, False),
    ],
)
def test_an_order_runs_on_a_cell_or_on_a_robots_drivers_by_their_time(given, nodes, simulated_time):
    loaded = order_launch(*given)
    types = {node.type for node in loaded.nodes}
    assert types & {"cell", "abilities", "robot_driver", "fake_cell"} == nodes
    time = loaded.params.get("/use_sim_time")
    assert (time.value if time else None) is simulated_time


def order_launch(*given):
    """Return what order.launch starts with arguments."""
    file = SKILLS.parent / "remodel_planner/launch/order.launch"
    loaded = roslaunch.config.ROSLaunchConfig()
    arguments = ["output:=/out", "database:=sqlite:////out/p.sqlite", *given]
    roslaunch.xmlloader.XmlLoader().load(str(file), loaded, argv=arguments, verbose=False)
    return loaded


def test_a_bag_of_an_order_has_what_its_nodes_report_and_no_topic_of_commands():
    assert not [node for node in order_launch().nodes if node.package == "rosbag"]
    (recorder,) = (node for node in order_launch("bag:=true").nodes if node.package == "rosbag")
    assert recorder.type == "record"
    words = recorder.args.split()
    assert words[:2] == ["-o", "/out/bags/run"]
    actions = [ability.topic for ability in read_abilities().values()]
    assert {f"{topic}/{part}" for topic in actions for part in ("goal", "result")} <= set(words)
    reported = {"flexbe/status", "flexbe/log", "remodel/use_case/state", "remodel/ability_records"}
    assert reported <= set(words)
    commands = {"flexbe/uicommand", "flexbe/start_behavior", "remodel/run_use_case/goal"}
    assert not [word for word in words if word in commands or word.startswith("flexbe/command/")]
    assert not [word for word in words if "image" in word]


@pytest.mark.parametrize("gui", [True, False])
def test_gui_asks_pybullet_for_its_window(monkeypatch, gui):
    asked = []

    def connect(*, gui):
        asked.append(gui)
        return bullet.connect()

    monkeypatch.setattr(world, "connect", connect)
    SimulatedPlant(panel(), gui=gui).close()
    assert asked == [gui]
