"""What the launch file offers reaches the cell."""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from panels import panel

from remodel_sim.physics import world
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros import node
from remodel_skills.ros import node as skills_node
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
    assert f'"~{name}"' in Path(node.__file__).read_text() + Path(skills_node.__file__).read_text()


@pytest.mark.parametrize("gui", [True, False])
def test_gui_asks_pybullet_for_its_window(monkeypatch, gui):
    asked = []

    def connect(*, gui):
        asked.append(gui)
        return bullet.connect()

    monkeypatch.setattr(world, "connect", connect)
    SimulatedPlant(panel(), gui=gui).close()
    assert asked == [gui]


def test_pybullet_prints_nothing_by_itself():
    made = "from remodel_work.edge.bullet import connect; connect(); print('ready')"
    done = subprocess.run([sys.executable, "-c", made], capture_output=True, text=True, check=True)
    assert done.stdout == "ready\n"
