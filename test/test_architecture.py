"""The rules of the house (docs/architecture.md), checked from the imports of every package.

An import under `if TYPE_CHECKING` does not count: it is none when the program runs.
"""

import ast
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src"
PACKAGES = {
    path.name: path / "src" / path.name
    for path in (*SRC.iterdir(), *(SRC / "flexbe").iterdir())
    if (path / "src" / path.name).is_dir()
}
ROS = {"rospy", "actionlib", "roslib", "genpy", "tf", "tf2_ros", "std_srvs"}
OUTSIDE = {"os", "pathlib", "subprocess", "tempfile", "threading", "time", "socket"}
OUTSIDE |= {"rospkg", "sqlalchemy"}
# The pure room of each package that has one; commands may initialise ROS, states are made of it.
CORES = {"flexbe_core": "engine", "flexbe_synthesizer": "core", "remodel_console": "core"}
CORES |= {"remodel_planner": "core", "remodel_sim": "core", "remodel_states": "core"}
ROS_ROOMS = {"ros", "commands"}
MAY_IMPORT = {
    "flexbe_synthesizer": {"flexbe_core"},
    "remodel_states": {"flexbe_core"},
    "remodel_behaviors": {"flexbe_core", "flexbe_states", "remodel_states"},
    "remodel_sim": {"flexbe_core", "remodel_states"},
    "remodel_planner": {"flexbe_core", "flexbe_synthesizer", "remodel_states"},
    "remodel_console": {"flexbe_core", "flexbe_synthesizer"},
}


def modules(package):
    """Map the dotted names of a package's modules to their files."""
    folder = PACKAGES[package]
    return {
        ".".join(path.relative_to(folder.parent).with_suffix("").parts).removesuffix(
            ".__init__"
        ): path
        for path in folder.rglob("*.py")
    }


def imported_names(path):
    """Yield every name that a file imports when it is loaded, with the attributes."""
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


def room(name):
    """Return the first folder below the package that a module lies in."""
    return name.split(".")[1] if "." in name else ""


def from_ros(names):
    tops = {name.split(".")[0] for name in names}
    return {top for top in tops if top in ROS or top.endswith("_msgs")}


@pytest.mark.parametrize("package", CORES)
def test_the_core_is_pure(package):
    for name, path in modules(package).items():
        if room(name) == CORES[package]:
            names = set(imported_names(path))
            assert not from_ros(names), name
            assert not {n.split(".")[0] for n in names} & OUTSIDE, name
            inside = {n for n in names if n.startswith(f"{package}.")}
            allowed = (f"{package}.{CORES[package]}", f"{package}.errors")
            assert all(n.startswith(allowed) for n in inside), name


@pytest.mark.parametrize("package", sorted(set(CORES) - {"flexbe_core", "remodel_states"}))
def test_only_the_rooms_for_it_know_ros(package):
    for name, path in modules(package).items():
        if room(name) not in ROS_ROOMS:
            assert not from_ros(imported_names(path)), name


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_form_no_cycle(package):
    paths = modules(package)
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


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_packages_import_one_way(package):
    others = set(PACKAGES) - {package} - MAY_IMPORT[package]
    for name, path in modules(package).items():
        tops = {imported.split(".")[0] for imported in imported_names(path)}
        assert not tops & others, name


@pytest.mark.parametrize("package", ["remodel_planner", "flexbe_synthesizer", "remodel_sim"])
def test_only_the_care_for_master_and_clock_is_taken_from_the_engine(package):
    allowed = ("flexbe_core.ros.master", "flexbe_core.ros.steady_action_server")
    for name, path in modules(package).items():
        found = {n for n in imported_names(path) if n.startswith("flexbe_core")}
        assert all(n.startswith(allowed) for n in found), name


def test_nodes_join_ros_by_the_one_module_that_handles_signals():
    """rospy's own handler of signals deadlocks in a node that is being set up."""
    programs = [*SRC.glob("*/nodes/*"), *SRC.glob("flexbe/*/nodes/*")]
    files = [*programs, *(path for package in PACKAGES for path in modules(package).values())]
    joining = {path for path in files if "rospy.init_node(" in path.read_text()}
    spinning = {path for path in files if "rospy.spin(" in path.read_text()}
    # The judge of engines imports nothing of this one; as a command, it leaves signals to Python.
    judge = modules("flexbe_testing")["flexbe_testing.ros.conformance.command"]
    assert joining == {modules("flexbe_core")["flexbe_core.ros.master"], judge}
    assert all("disable_signals=True" in path.read_text() for path in joining)
    assert not spinning


def test_only_the_room_physics_knows_pybullet():
    for name, path in modules("remodel_sim").items():
        if room(name) != "physics":
            tops = {imported.split(".")[0] for imported in imported_names(path)}
            assert not {top for top in tops if top.startswith("pybullet")}, name


def test_abilities_never_ask_for_the_truth():
    for name, path in modules("remodel_sim").items():
        if room(name) == "abilities":
            assert "remodel_sim.physics.truth" not in set(imported_names(path)), name
