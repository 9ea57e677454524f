"""The rules of the house, checked: the engine imports no ROS, and imports form no cycle."""

import ast
from pathlib import Path

SRC = Path(__file__).parents[2] / "src"
OUTSIDE = {"rospy", "actionlib", "roslib", "rospkg", "genpy", "tf", "tf2_ros", "threading", "time"}


def module_paths():
    """Map each module's dotted name to its file."""
    return {
        ".".join(p.relative_to(SRC).with_suffix("").parts).replace(".__init__", ""): p
        for p in SRC.rglob("*.py")
    }


def imported_names(path):
    """Yield every name that the file imports when it is loaded, with the attributes."""
    tree = ast.parse(path.read_text())
    for block in [node for node in ast.walk(tree) if is_type_checking(node)]:
        block.body.clear()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def is_type_checking(node):
    return isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"


def test_the_engine_imports_no_ros_and_no_clock():
    for name, path in module_paths().items():
        if ".engine" in name:
            tops = {imported.split(".")[0] for imported in imported_names(path)}
            outside = {top for top in tops if top in OUTSIDE or top.endswith("_msgs")}
            assert not outside, f"{name} imports {sorted(outside)}"


def test_the_engine_imports_nothing_of_its_shell():
    for name, path in module_paths().items():
        if ".engine" in name:
            shell = {
                imported
                for imported in imported_names(path)
                if imported.startswith("flexbe_core.") and ".engine" not in imported
            }
            assert not shell, f"{name} imports {sorted(shell)}"


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
