"""The rules of the house (docs/architecture.md), checked from the imports of every package.

An import under `if TYPE_CHECKING` is none when the program runs. It counts only for the order of
modules and folders: what lies below is to be understood without what lies above.
"""

import ast
from collections import Counter
from fnmatch import fnmatch
from graphlib import CycleError, TopologicalSorter
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
CORES |= {
    "remodel_production": "core",
    "remodel_planning": "core",
    "remodel_cable_tree": "core",
    "remodel_pddl": "core",
    "remodel_supervision": "core",
    "remodel_sim": "core",
    "remodel_robot": "core",
    "remodel_states": "core",
}
ROS_ROOMS = {"ros", "commands"}
# The rooms of a core, each above the rooms that it may import.
LAYERS = {
    "remodel_production": ["errors", "core", "edge"],
    "remodel_planning": ["errors", "core", "edge"],
    "remodel_planning.core": [
        *("condition", "cycle", "problem", "search", "plan", "use_case", "orders"),
        *("decomposition", "task_charts"),
    ],
    "remodel_supervision": ["errors", "core", "edge", "supervisors", "ros"],
    "remodel_supervision.core": ["run", "trace", "runs", "recovery", "learning"],
    "flexbe_synthesizer.core": [
        *("chart", "rewrite", "library", "machine", "check", "export", "compile"),
    ],
}
# Modules that no import of a program reaches, but that are found by their name or their place.
ENTRY_POINTS = {
    "flexbe_states.*_state",  # states, found in the text of their package
    "remodel_sim.abilities.*",  # abilities, found by their place (abilities/ability.py)
    "remodel_states.*_state",
    "remodel_behaviors.*_sm",  # behaviors, named by their manifests
    "flexbe_core.core.exceptions",  # FlexBE's import path
    "flexbe_core.testing",  # for the tests of state packages (README of flexbe_core)
    "flexbe_testing.ros.doctor.construct",  # a program of its own
    "remodel_production.edge.database.migrations.*",  # loaded by Alembic
    "remodel_planner.commands.*",  # named by commands/planner.py
}
MAX_MODULES = 15
OWNED_NAMES = ("End", "Wire", "Terminal", "Arm", "Cable", "Clip", "Fault", "Code", "Answer")
# What does not keep the rules yet. An entry that is no longer needed fails: these lists shrink.
FOLDERS_WITH_CYCLE = {
    "flexbe_core",  # FlexBE's import paths: its states publish, its proxies wait as states do
    "flexbe_core.engine",  # a node knows its container, the engine and the active leaf
}
LARGE_FOLDERS = {
    "flexbe_core.core",  # FlexBE's import paths: a module for each class
}
TEST_MODULES = {
    "remodel_console.testing.browser_test",
}
MAY_IMPORT = {
    "flexbe_synthesizer": {"flexbe_core"},
    "remodel_states": {"flexbe_core"},
    "remodel_behaviors": {"flexbe_core", "flexbe_states", "remodel_states"},
    "remodel_sim": {"flexbe_core", "remodel_states"},
    "remodel_robot": {"flexbe_core", "remodel_states"},
    "remodel_production": {"remodel_states"},
    "remodel_planning": {"remodel_production", "flexbe_synthesizer", "remodel_states"},
    "remodel_cable_tree": {"remodel_production", "remodel_planning"},
    "remodel_pddl": {"remodel_production", "remodel_planning"},
    "remodel_supervision": {
        "remodel_production",
        "remodel_planning",
        "flexbe_core",
        "flexbe_synthesizer",
        "remodel_states",
    },
    "remodel_planner": {
        "remodel_production",
        "remodel_planning",
        "remodel_cable_tree",
        "remodel_pddl",
        "remodel_supervision",
        "flexbe_core",
        "flexbe_synthesizer",
        "remodel_states",
    },
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
    yield from names_in(tree)


def named_modules(path):
    """Yield what a file imports, also for its types only."""
    return names_in(ast.parse(path.read_text()))


def names_in(tree):
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
            inside = {n for n in names if "." in n and n.split(".")[0] in CORES}
            allowed = tuple(f"{p}.{r}" for p in CORES for r in (CORES[p], "errors"))
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


def folders(package):
    """Map each folder to the imports between what lies directly in it: modules and folders."""
    paths = {n: p for n, p in modules(package).items() if p.name != "__init__.py"}
    found = {}
    for name, path in paths.items():
        for imported in set(named_modules(path)) & set(paths):
            folder, ours, theirs = parted(name, imported)
            found.setdefault(folder, {}).setdefault(ours, set()).add(theirs)
    return found


def parted(name, other):
    """Return the folder that two modules share, and what each is, or is in, there."""
    depth = 0
    parts, others = name.split("."), other.split(".")
    while parts[depth] == others[depth]:
        depth += 1
    return ".".join(parts[:depth]), parts[depth], others[depth]


def has_cycle(graph):
    try:
        TopologicalSorter(graph).prepare()
    except CycleError:
        return True
    return False


def test_modules_and_folders_import_one_way():
    """In each folder, also for types only; a folder counts as one, with all that is in it."""
    found = {
        folder
        for package in PACKAGES
        for folder, graph in folders(package).items()
        if has_cycle(graph)
    }
    assert found == FOLDERS_WITH_CYCLE


@pytest.mark.parametrize("core", LAYERS)
def test_a_room_imports_only_the_rooms_below(core):
    order = LAYERS[core]
    for ours, imported in folders(core.split(".")[0])[core].items():
        below = order[: order.index(ours)]
        assert imported <= set(below), ours


def test_no_folder_holds_more_modules_than_a_reader_can_survey():
    sizes = Counter(
        name.rpartition(".")[0]
        for package in PACKAGES
        for name, path in modules(package).items()
        if path.name != "__init__.py"
    )
    assert {folder for folder, size in sizes.items() if size > MAX_MODULES} == LARGE_FOLDERS


def test_src_holds_only_what_a_program_uses():
    """What only tests and benchmarks import belongs beside them."""
    paths = {name: path for package in PACKAGES for name, path in modules(package).items()}
    programs = [p for p in (*SRC.glob("*/nodes/*"), *SRC.glob("flexbe/*/nodes/*")) if p.is_file()]
    used = reached({name for path in programs for name in named_modules(path)} & set(paths), paths)
    by_name = {n for n in paths for pattern in ENTRY_POINTS if fnmatch(n, pattern)}
    unused = {n for n in paths if paths[n].name != "__init__.py"} - used
    idle = {pattern for pattern in ENTRY_POINTS if not any(fnmatch(n, pattern) for n in unused)}
    assert not idle, "entry points that a program imports, or that are gone"
    assert unused - reached(by_name, paths) == TEST_MODULES


def reached(start, paths):
    """Return the modules that some import, directly or through others, and themselves."""
    found, todo = set(), set(start)
    while todo:
        name = todo.pop()
        found.add(name)
        parents = {name.rpartition(".")[0]} & set(paths)
        todo |= (parents | set(named_modules(paths[name])) & set(paths)) - found
    return found


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_packages_import_one_way(package):
    others = set(PACKAGES) - {package} - MAY_IMPORT[package]
    for name, path in modules(package).items():
        tops = {imported.split(".")[0] for imported in imported_names(path)}
        assert not tops & others, name


@pytest.mark.parametrize(
    "package", ["remodel_planner", "remodel_supervision", "flexbe_synthesizer", "remodel_sim"]
)
def test_only_the_care_for_master_clock_and_connections_is_taken_from_the_engine(package):
    modules_allowed = ("connections", "master", "steady_action_server")
    allowed = tuple(f"flexbe_core.ros.{name}" for name in modules_allowed)
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


def definitions():
    """Yield every class and function of the product: its file and its syntax."""
    kinds = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    for package in PACKAGES:
        for path in modules(package).values():
            yield from (
                (path, n) for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, kinds)
            )


def test_each_of_these_names_has_one_owner():
    """What several packages speak of is one class, or has a name that says which one is meant."""
    owners = {name: [] for name in OWNED_NAMES}
    for path, node in definitions():
        if isinstance(node, ast.ClassDef) and node.name in owners:
            owners[node.name].append(str(path.relative_to(SRC)))
    assert {name: files for name, files in owners.items() if len(files) != 1} == {}


def test_every_function_has_a_name():
    nameless = [f"{path.relative_to(SRC)}:{n.lineno}" for path, n in definitions() if n.name == "_"]
    assert nameless == []
