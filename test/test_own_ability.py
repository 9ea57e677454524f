"""Charts know the error codes of a package that create_ability makes, as its states do.

That such a package builds and keeps the contract is tutorial 3 (test_tutorials.py).
"""

import os
import shutil
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.error_routes import ABOVE_BEHAVIOR, RECOVERABLE, SERIOUS
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from remodel_states.commands.create_ability import main as create_ability
from remodel_states.edge.exported_tables import read_faults

SECOND_TABLE = """
no_fault:
  - {code: 1001, name: JAW_WORN, meaning: "The jaw is worn.", remedy: "Order another one."}
"""


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
