"""The rules of the house, checked: who may import what, and no import cycle."""

import ast
from pathlib import Path

SRC = Path(__file__).parents[2] / "src"
ROS = {"rospy", "actionlib", "actionlib_msgs", "genpy", "tf2_ros", "std_srvs"}


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


def test_only_the_room_ros_knows_ros():
    for name, path in module_paths().items():
        if ".ros" not in name:
            tops = {imported.split(".")[0] for imported in imported_names(path)}
            ros = {top for top in tops if top in ROS or top.endswith("_msgs")}
            assert not ros, f"{name} imports {sorted(ros)}"


def test_only_the_room_physics_knows_pybullet():
    for name, path in module_paths().items():
        tops = {imported.split(".")[0] for imported in imported_names(path)}
        if ".physics" not in name:
            assert not {top for top in tops if top.startswith("pybullet")}, name
        if ".core" in name:
            inside = {i for i in imported_names(path) if i.startswith("remodel_sim.")}
            assert all(i.startswith("remodel_sim.core") for i in inside), name


def test_abilities_never_ask_for_the_truth():
    for name, path in module_paths().items():
        if ".abilities" in name:
            assert "remodel_sim.physics.truth" not in set(imported_names(path)), name


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
