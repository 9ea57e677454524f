"""A package that create_ability makes in another workspace builds, and its own test passes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.error_names import ABOVE_BEHAVIOR, RECOVERABLE, SERIOUS
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from remodel_states.commands.create_ability import main as create_ability
from remodel_states.edge.exported_tables import read_faults

# [s] Wall time of one command; the machine may be busy.
LIMIT_S = 300.0

# What the workspace's nodes find of the new package.
FOUND = """
from remodel_states.serving.ability_messages import message_class
from remodel_states.edge.exported_tables import read_abilities, read_faults
crimp = read_abilities()["CrimpFerrule"]
print(message_class(crimp, "Goal").__slots__, dict(crimp.fake))
print(read_faults().numbers["CRIMP_FERRULE_FAILED"])
"""

SECOND_TABLE = """
no_fault:
  - {code: 1001, name: JAW_WORN, meaning: "The jaw is worn.", remedy: "Order another one."}
"""


def run(folder, *lines):
    """Run lines of shell; return what they print."""
    # Messages for Python alone: the others take most of the time of a build.
    other_languages = "gencpp:geneus:genlisp:gennodejs"
    done = subprocess.run(
        ["bash", "-e", "-c", "\n".join(lines)],
        cwd=folder,
        env={**os.environ, "ROS_LANG_DISABLE": other_languages, "PYTHON": sys.executable},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_new_ability_out_of_tree_keeps_the_contract_at_once(tmp_path):
    (tmp_path / "src").mkdir()
    created = run(tmp_path, "rosrun remodel_states create_ability CrimpFerrule --into src")
    assert "action/CrimpFerrule.action" in created
    run(tmp_path, 'catkin_make --no-color -DPYTHON_EXECUTABLE="$PYTHON"')
    sourced = ". devel/setup.bash"
    found = run(tmp_path, sourced, f"python3 -c '{FOUND}'")
    assert found == "['id', 'target_id', 'force_limit', 'timeout'] {'peak_force': 5.0}\n1000\n"
    ran = run(tmp_path, sourced, "rostest crimp_ferrule crimp_ferrule.test")
    assert "TESTS: 4" in ran
    run(tmp_path, 'catkin_make --no-color -DPYTHON_EXECUTABLE="$PYTHON" install')
    share = tmp_path / "install/share/crimp_ferrule"
    written = ("manifest/crimp_ferrule.xml", "certificate/crimp_ferrule.yaml")
    assert [name for name in written if not (share / name).is_file()] == []


def known_to_charts(path):
    """Return the names that charts can route by, with their codes."""
    library, warnings = read_library(find_packages(path)[0])
    assert not warnings
    return library.error_names


def known_to_states():
    """Return the same from the tables that abilities, states and supervisors use."""
    tables = read_faults()
    numbers = {name: (number,) for name, number in tables.numbers.items() if number}
    rows = [row for row in tables.faults.values() if "after" not in row]
    classes = {
        ABOVE_BEHAVIOR: [row for row in rows if row["first_level"] in ("task", "use_case")],
        RECOVERABLE: [row for row in rows if row["severity"] == RECOVERABLE],
        SERIOUS: [row for row in rows if row["severity"] == SERIOUS],
    }
    codes = {
        name: tuple(sorted(tables.numbers[code] for row in rows for code in row["codes"]))
        for name, rows in classes.items()
    }
    return {**numbers, **codes}


@pytest.mark.parametrize("exports", ["one element", "two elements", "a second table"])
def test_charts_know_the_codes_that_states_know(tmp_path, monkeypatch, exports):
    path = os.environ["ROS_PACKAGE_PATH"]
    assert known_to_charts(path) == known_to_states()
    assert create_ability(["CrimpFerrule", "--into", str(tmp_path)]) == 0
    package = tmp_path / "crimp_ferrule"
    if exports != "one element":
        (package / "config/faults.yaml").write_text(SECOND_TABLE)
        manifest = package / "package.xml"
        attribute = 'faults="${prefix}/config/faults.yaml"'
        ours = (
            f"<remodel_states {attribute} "
            if exports == "a second table"
            else f"<remodel_states {attribute}/><remodel_states "
        )
        manifest.write_text(manifest.read_text().replace("<remodel_states ", ours))
    monkeypatch.setenv("ROS_PACKAGE_PATH", path := f"{package}:{path}")
    found = known_to_charts(path)
    assert found["CRIMP_FERRULE_FAILED"] == (1000,)
    assert 1000 in found[RECOVERABLE]
    assert ("JAW_WORN" in found) == (exports != "one element")
    assert found == known_to_states()


def test_charts_know_the_codes_in_the_table_of_the_workspace_own_abilities(tmp_path, monkeypatch):
    messages = Path(__file__).parents[1] / "src/remodel_msgs"
    copy = shutil.copytree(messages, tmp_path / "remodel_msgs")
    table = copy / "config/abilities.yaml"
    table.write_text(table.read_text() + SECOND_TABLE.replace("1001", "499"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", path := f"{copy}:{os.environ['ROS_PACKAGE_PATH']}")
    assert known_to_charts(path)["JAW_WORN"] == (499,)
    assert known_to_charts(path) == known_to_states()
