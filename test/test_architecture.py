"""The rules of the house (docs/architecture.md), checked from the imports of every package.

An import under `if TYPE_CHECKING` is none when the program runs. It counts only for the order of
modules and folders: what lies below is to be understood without what lies above.
"""

import ast
import tomllib
from collections import Counter
from fnmatch import fnmatch
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

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
    "remodel_tasks": "core",
    "remodel_cable_tree": "problem",
    "remodel_supervision": "core",
    "remodel_rehearsal": "core",
    "remodel_sim": "core",
    "remodel_robot": "calibration",
    "remodel_states": "core",
}
# Packages that are pure but for these rooms.
PURE = {"remodel_run", "remodel_work", "remodel_vision", "remodel_skills", "remodel_pddl"}
ROS_ROOMS = {"ros", "commands"}
# The rooms of a core, each above the rooms that it may import.
LAYERS = {
    "remodel_production": ["errors", "core", "edge"],
    "remodel_tasks": ["errors", "core", "edge"],
    "remodel_tasks.core": [
        *("condition", "problem", "search", "plan", "use_case", "orders"),
        *("decomposition", "task_charts"),
    ],
    "remodel_supervision": ["errors", "core", "edge", "supervisors", "ros"],
    "remodel_supervision.core": ["run", "runs", "recovery", "learning"],
    "flexbe_synthesizer.core": [
        *("chart", "library", "machine", "check", "export", "compile"),
    ],
}
# Modules that no import of a program reaches, but that are found by their name or their place.
ENTRY_POINTS = {
    "flexbe_states.*_state",  # states, found in the text of their package
    "remodel_skills.abilities.*",  # abilities, found by their place (abilities/ability.py)
    "remodel_states.*_state",
    "remodel_behaviors.*_sm",  # behaviors, named by their manifests
    "flexbe_core.core.exceptions",  # FlexBE's import path
    "flexbe_core.testing",  # for the tests of state packages (README of flexbe_core)
    "flexbe_testing.ros.doctor_child",  # a program of its own
    "remodel_production.edge.database.migrations.*",  # loaded by Alembic
    "remodel_planner.commands.*",  # named by commands/remodel.py
}
# Module constants of the skills with numbers: none is of a tool, a wire, a terminal or a motion.
NUMBERS_OF_SKILLS = {
    "force_control.RIGID",  # no direction
    "motion.PEAK_ACCELERATION",  # of a minimum-jerk motion
    "motion.PEAK_OVER_MEAN",  # the same
}
MAX_MODULES = 25
MAX_METHODS = 15
OWNED_NAMES = ("End", "Wire", "Terminal", "Arm", "Cable", "Clip", "Fault", "Code", "Answer")
# What does not keep the rules yet. An entry that is no longer needed fails: these lists shrink.
FOLDERS_WITH_CYCLE = {
    "flexbe_core",  # FlexBE's import paths: its states publish, its proxies wait as states do
    "flexbe_core.engine",  # a node knows its container, the engine and the active leaf
}
TEST_MODULES = {
    "remodel_console.testing.browser_test",
}
MAY_IMPORT = {
    "flexbe_synthesizer": {"flexbe_core"},
    "remodel_states": {"flexbe_core"},
    "remodel_behaviors": {"flexbe_core", "flexbe_states", "remodel_states"},
    "remodel_work": {"remodel_states"},
    "remodel_vision": {"flexbe_core", "remodel_states", "remodel_work"},
    "remodel_skills": {"flexbe_core", "remodel_states", "remodel_work", "remodel_vision"},
    "remodel_sim": {
        "flexbe_core",
        "remodel_states",
        "remodel_work",
        "remodel_vision",
        "remodel_skills",
    },
    "remodel_robot": set(),
    "remodel_run": set(),
    "remodel_production": {"remodel_run", "remodel_states"},
    "remodel_tasks": {
        "remodel_run",
        "remodel_production",
        "flexbe_synthesizer",
        "remodel_states",
    },
    "remodel_cable_tree": {"remodel_production", "remodel_tasks"},
    "remodel_pddl": {"remodel_production", "remodel_tasks"},
    "remodel_supervision": {
        "remodel_run",
        "remodel_production",
        "remodel_tasks",
        "flexbe_core",
        "flexbe_synthesizer",
        "remodel_states",
    },
    "remodel_rehearsal": {
        "remodel_run",
        "remodel_production",
        "remodel_tasks",
        "remodel_supervision",
        "flexbe_core",
        "flexbe_synthesizer",
        "remodel_states",
        "remodel_work",
        "remodel_skills",
        "remodel_sim",
    },
    "remodel_planner": {
        "remodel_rehearsal",
        "remodel_run",
        "remodel_production",
        "remodel_tasks",
        "remodel_cable_tree",
        "remodel_pddl",
        "remodel_supervision",
        "flexbe_core",
        "flexbe_synthesizer",
        "remodel_states",
    },
    "remodel_console": {"flexbe_core", "flexbe_synthesizer", "remodel_run"},
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


@cache
def imported_names(path):
    """Return every name that a file imports when it is loaded, with the attributes."""
    tree = ast.parse(path.read_text())
    for block in [node for node in ast.walk(tree) if is_type_checking(node)]:
        block.body.clear()
    return tuple(names_in(tree))


@cache
def named_modules(path):
    """Return what a file imports, also for its types only."""
    return tuple(names_in(ast.parse(path.read_text())))


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


def test_the_cores_are_pure():
    allowed = tuple(f"{package}.{room}" for package in CORES for room in (CORES[package], "errors"))
    allowed += tuple(PURE)
    impure = []
    for package, core in CORES.items():
        for name, path in modules(package).items():
            if room(name) == core:
                names = set(imported_names(path))
                inside = {n for n in names if "." in n and n.split(".")[0] in CORES}
                bad = from_ros(names) | {n.split(".")[0] for n in names} & OUTSIDE
                bad |= {n for n in inside if not n.startswith(allowed)}
                impure += [f"{name} imports {n}" for n in sorted(bad)]
    for package in PURE:
        for name, path in modules(package).items():
            if room(name) not in ROS_ROOMS | {"edge"}:
                names = set(imported_names(path))
                bad = from_ros(names) | {n.split(".")[0] for n in names} & OUTSIDE
                bad |= {n for n in names if n.startswith("remodel_") and not n.startswith(allowed)}
                impure += [f"{name} imports {n}" for n in sorted(bad)]
    assert impure == []


def test_only_the_rooms_for_it_know_ros():
    found = [
        name
        for package in sorted(set(CORES) - {"flexbe_core", "remodel_states"})
        for name, path in modules(package).items()
        if room(name) not in ROS_ROOMS and from_ros(imported_names(path))
    ]
    assert found == []


def test_imports_form_no_cycle():
    paths = {name: path for package in PACKAGES for name, path in modules(package).items()}
    graph = {name: set(imported_names(path)) & set(paths) for name, path in paths.items()}
    TopologicalSorter(graph).prepare()  # whose error names the cycle


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


def test_a_room_imports_only_the_rooms_below():
    above = [
        f"{core}.{ours} imports {other}"
        for core, order in LAYERS.items()
        for ours, imported in folders(core.split(".")[0])[core].items()
        for other in sorted(imported - set(order[: order.index(ours)]))
    ]
    assert above == []


def test_no_folder_holds_more_modules_than_a_reader_can_survey():
    sizes = Counter(
        name.rpartition(".")[0]
        for package in PACKAGES
        for name, path in modules(package).items()
        if path.name != "__init__.py"
    )
    assert {folder for folder, size in sizes.items() if size > MAX_MODULES} == set()


def test_every_file_of_tests_is_collected():
    """pytest collects `test_*.py` where pyproject.toml says; a ROS test is one of a .test file."""
    settings = tomllib.loads((SRC.parent / "pyproject.toml").read_text())["tool"]["pytest"]
    patterns = settings["ini_options"]["testpaths"]
    collected = {file for p in patterns for file in SRC.parent.glob(f"{p}/**/test_*.py")}
    written = {*SRC.parent.glob("test/**/test_*.py"), *SRC.rglob("test/**/test_*.py")}
    assert sorted(written - collected) == []


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


def test_packages_import_one_way():
    found = [
        f"{name} imports {top}"
        for package, may in MAY_IMPORT.items()
        for name, path in modules(package).items()
        for top in {imported.split(".")[0] for imported in imported_names(path)}
        if top in set(PACKAGES) - {package} - may
    ]
    assert found == []


def test_only_the_care_for_master_clock_and_connections_is_taken_from_the_engine():
    allowed = ("flexbe_core.ros.master",)
    packages = ("remodel_planner", "remodel_supervision", "flexbe_synthesizer")
    packages += ("remodel_sim", "remodel_skills", "remodel_vision")
    found = [
        f"{name} imports {imported}"
        for package in packages
        for name, path in modules(package).items()
        for imported in imported_names(path)
        if imported.startswith("flexbe_core") and not imported.startswith(allowed)
    ]
    assert found == []


def test_nodes_join_ros_by_the_one_module_that_handles_signals():
    """rospy's own handler of signals deadlocks in a node that is being set up."""
    programs = [*SRC.glob("*/nodes/*"), *SRC.glob("flexbe/*/nodes/*")]
    files = [*programs, *(path for package in PACKAGES for path in modules(package).values())]
    joining = {path for path in files if "rospy.init_node(" in path.read_text()}
    spinning = {path for path in files if "rospy.spin(" in path.read_text()}
    # The judge of engines imports nothing of this one; as a command, it leaves signals to Python.
    judge = modules("flexbe_testing")["flexbe_testing.ros.conformance"]
    assert joining == {modules("flexbe_core")["flexbe_core.ros.master"], judge}
    assert all("disable_signals=True" in path.read_text() for path in joining)
    assert not spinning


def test_only_the_room_physics_knows_pybullet():
    for name, path in modules("remodel_sim").items():
        if room(name) != "physics":
            tops = {imported.split(".")[0] for imported in imported_names(path)}
            assert not {top for top in tops if top.startswith("pybullet")}, name


def test_the_simulator_knows_of_skills_only_the_device_port():
    port = tuple(f"remodel_skills.{module}" for module in ("device", "force_control"))
    for name, path in modules("remodel_sim").items():
        skills = {n for n in imported_names(path) if n.startswith("remodel_skills.")}
        assert not {n for n in skills if not n.startswith(port)}, name


def test_packages_without_a_simulator_are_tested_without_one():
    """Robots are scripted and pictures drawn: what needs physics is tested in remodel_sim."""
    found = [
        f"{path.relative_to(SRC)} imports {name}"
        for package in sorted(PURE)
        for path in (SRC / package / "test").rglob("*.py")
        for name in imported_names(path)
        if name.split(".")[0] == "remodel_sim"
    ]
    assert found == []


def test_the_numbers_of_the_skills_are_data():
    """A module constant of a skill would be a number without unit, meaning, origin and override.

    Drivers and files, in `ros` and `edge`, have constants of their own.
    """
    found = {
        f"{name}.{target.id}"
        for name, path in modules("remodel_skills").items()
        if room(name) not in ("ros", "edge")
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None
        if any(isinstance(n, ast.Constant) and is_number(n.value) for n in ast.walk(node.value))
        for target in ast.walk(node)
        if isinstance(target, ast.Name) and isinstance(target.ctx, ast.Store)
    }
    assert found == {f"remodel_skills.{name}" for name in NUMBERS_OF_SKILLS}


def is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool)


def test_no_class_of_the_skills_has_more_methods_than_a_reader_can_survey():
    large = [
        node.name
        for path in modules("remodel_skills").values()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef)
        and sum(isinstance(each, ast.FunctionDef) for each in node.body) > MAX_METHODS
    ]
    assert large == []


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
