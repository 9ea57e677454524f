"""The core of the console knows neither ROS nor the disk."""

import ast
from pathlib import Path

SRC = Path(__file__).parents[2] / "src" / "remodel_console"
OUTSIDE = {"rospy", "os", "pathlib", "subprocess", "threading", "time", "std_msgs", "flexbe_msgs"}


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def test_the_core_is_pure():
    for path in (SRC / "core").glob("*.py"):
        names = set(imported(path))
        assert not {name.split(".")[0] for name in names} & OUTSIDE, path
        assert not {name for name in names if ".edge" in name or ".ros" in name}, path


def test_only_the_ros_room_imports_ros():
    for path in SRC.rglob("*.py"):
        if path.parent.name != "ros":
            tops = {name.split(".")[0] for name in imported(path)}
            assert not {top for top in tops if top == "rospy" or top.endswith("_msgs")}, path
