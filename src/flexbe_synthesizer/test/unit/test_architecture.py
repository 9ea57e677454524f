"""The rules of the house: the core knows neither ROS nor the disk, and imports form no cycle."""

import ast
from pathlib import Path

SRC = Path(__file__).parents[2] / "src"
ROS = {"rospy", "actionlib", "roslib", "rospkg", "genpy"}
OUTSIDE = {"os", "pathlib", "subprocess", "tempfile", "threading", "time", "random", "socket"}


def module_paths():
    return {
        ".".join(p.relative_to(SRC).with_suffix("").parts).replace(".__init__", ""): p
        for p in SRC.rglob("*.py")
    }


def imported_names(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_only_the_ros_room_imports_ros():
    for name, path in module_paths().items():
        if ".ros" not in name:
            tops = {imported.split(".")[0] for imported in imported_names(path)}
            assert not {top for top in tops if top in ROS or top.endswith("_msgs")}, name


def test_the_core_touches_no_disk_process_thread_or_clock():
    for name, path in module_paths().items():
        if ".core" in name:
            tops = {imported.split(".")[0] for imported in imported_names(path)}
            assert not tops & OUTSIDE, name
            assert not {i for i in imported_names(path) if ".edge" in i or ".errors." in i}, name


def test_imports_form_no_cycle():
    paths = module_paths()
    graph = {name: set(imported_names(path)) & set(paths) for name, path in paths.items()}
    acyclic = set()

    def visit(name, trail):
        assert name not in trail, " -> ".join([*trail, name])
        if name not in acyclic:
            for imported in graph[name]:
                visit(imported, [*trail, name])
            acyclic.add(name)

    for name in graph:
        visit(name, [])
