"""flexbe_doctor on a sick workspace, on a healthy one, and on this one.

In the sick workspace a comment in each line with a finding names its rule.
"""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from flexbe_core import OperatableStateMachine
from flexbe_core.core import UserData
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.testing import ScriptedState
from flexbe_testing.core.doctor_module import Kind, Severity
from flexbe_testing.core.doctor_rules import OVERRIDES
from flexbe_testing.edge.doctor import attributes, diagnose, names_of

WORKSPACE = Path(__file__).parents[1] / "doctor_workspace"
SRC = Path(__file__).parents[4]
MARK = re.compile(r"# doctor: ([\w-]+)")


@pytest.fixture(scope="module")
def report():
    return diagnose(WORKSPACE, limit_s=3.0)


def expected(folder):
    """Yield file, line and rule of each mark below a folder."""
    for file in folder.rglob("*.py"):
        for number, line in enumerate(file.read_text().splitlines(), 1):
            for rule in MARK.findall(line):
                yield str(file), number, rule


def test_exactly_the_marked_lines_are_found(report):
    found = {(finding.file, finding.line, finding.rule) for finding in report.findings}
    assert found == set(expected(WORKSPACE))
    assert len({rule for _, _, rule in found}) == 17


def test_the_packages_are_those_that_catkin_would_build(report):
    assert report.packages == ("healthy_states", "sick_behaviors", "sick_states")
    assert report.behaviors == 2


def test_user_code_that_ends_its_process_costs_only_its_own_module(report):
    texts = {Path(f.file).name: f.text for f in report.findings if f.rule == "construction"}
    assert "ended the process with 7" in texts["ending_state.py"]
    assert "took more than 3 s" in texts["endless_state.py"]
    assert "IndexError: list index out of range" in texts["raising_state.py"]
    assert "'Nowhere'" in texts["lost_sm.py"]


def test_what_the_app_loses_of_a_behavior_is_one_note(report):
    (note,) = [f for f in report.findings if f.file.endswith("lost_sm.py") and f.rule == "app"]
    assert note.severity is Severity.NOTE
    assert "no block with date and author before the class; " in note.text
    assert "the App loses the transition of 'done' of '/Box/Wave' to 'Nowhere'" in note.text


def test_a_text_says_what_was_found_and_what_to_do(report):
    texts = {(Path(f.file).name, f.line): f.text for f in report.findings}
    assert texts["importing_state.py", 1].endswith("near it: EventState")
    assert "return None, or wake_at" in texts["sleeping_state.py", 13]
    assert "print(...)" in texts["printing_state.py", 6]
    assert "no_such_arm " in texts["missing_state.py", 2]


def run_doctor(*words):
    return subprocess.run(
        ["rosrun", "flexbe_testing", "flexbe_doctor", *map(str, words)],
        capture_output=True,
        text=True,
        timeout=60,
    )


def test_the_command_has_exit_codes_and_json():
    sick = run_doctor(WORKSPACE, "--static", "--json")
    assert sick.returncode == 1, sick.stderr
    rows = json.loads(sick.stdout)["findings"]
    assert {row["severity"] for row in rows} == {"error", "warning", "note"}
    text = run_doctor(WORKSPACE, "--static").stdout.splitlines()
    place = "src/sick_states/src/sick_states/sleeping_state.py:13: error [sleep] time.sleep sleeps"
    assert any(line.startswith(place) for line in text)
    assert text[-1].startswith("3 packages, ")


def test_a_healthy_package_has_no_finding():
    healthy = run_doctor(WORKSPACE / "src" / "healthy_states")
    assert healthy.returncode == 0, healthy.stdout
    assert len(healthy.stdout.splitlines()) == 1


def test_files_that_cannot_be_read_are_findings(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    package = tmp_path / "healthy_states"
    shutil.copytree(WORKSPACE / "src" / "healthy_states", package)
    (package / "manifest").mkdir()
    (package / "manifest" / "torn.xml").write_text("<behavior name=")
    (package / "package.xml").write_text(
        (package / "package.xml").read_text().replace("<flexbe_states/>", "<flexbe_behaviors/>")
    )
    (package / "src" / "healthy_states" / "latin_state.py").write_bytes(b"# \xe4\n")
    (package / "src" / "healthy_states" / "null_state.py").write_bytes(b"a\0b")
    (tmp_path / "torn_states").mkdir()
    (tmp_path / "torn_states" / "package.xml").write_text("<package><export><flexbe_states/>")
    found = diagnose(tmp_path, is_static=True)
    assert {(str(Path(f.file).relative_to(tmp_path)), f.rule) for f in found.findings} == {
        ("healthy_states/package.xml", "package"),
        ("healthy_states/src/healthy_states/latin_state.py", "syntax"),
        ("healthy_states/src/healthy_states/null_state.py", "syntax"),
        ("torn_states/package.xml", "package"),
    }
    assert "torn.xml is not XML" in found.findings[0].text


@pytest.mark.parametrize(
    ("folder", "text"),
    [("/no/such/folder", "is not a folder"), (WORKSPACE / "src" / "ignored", "exports")],
)
def test_a_wrong_folder_is_a_usage_error(folder, text):
    wrong = run_doctor(folder)
    assert wrong.returncode == 2
    assert text in wrong.stderr
    assert len(wrong.stderr.splitlines()) == 1


def test_this_workspace_is_healthy():
    found = diagnose(SRC)
    assert {"flexbe_states", "remodel_states", "remodel_behaviors"} <= set(found.packages)
    assert found.constructed > 10
    assert [finding for finding in found.findings if finding.is_bad] == []


def test_the_surface_is_that_of_the_engine():
    assert {"EventState", "Behavior", "wake_at"} <= names_of("flexbe_core")
    assert "ProxyActionClient" in names_of("flexbe_core.proxy")
    assert "StateMachine" in names_of("flexbe_core.core.state_machine")
    assert names_of("flexbe_core.loopback") is None
    assert {"_parent", "_locked", "transition_allowed"} <= attributes()


def test_what_is_reported_as_without_effect_has_none():
    """The engine calls no override of a machine or state that the rule names."""
    called = []

    def recording(base, kind):
        def method(name):
            def call(self, *args, **kwargs):
                called.append(name)
                return getattr(base, name)(self, *args, **kwargs)

            return call

        names = OVERRIDES[kind] & set(dir(base)) - {"execute"}
        return type(f"Recording{base.__name__}", (base,), {name: method(name) for name in names})

    class Machine(recording(OperatableStateMachine, Kind.MACHINE)):
        def execute(self, userdata):
            called.append("execute")
            return super().execute(userdata)

    state = recording(ScriptedState, Kind.STATE)
    root, box = Machine(outcomes=["finished"]), Machine(outcomes=["done"])
    with box:
        Machine.add("A", state([None, "done"]), {"done": "B"}, {"done": 0})
        Machine.add("B", state(["done"]), {"done": "done"}, {"done": 0})
    with root:
        Machine.add("Box", box, {"done": "finished"}, {"done": 0})
    engine = Engine(root, ErrorPolicy.FAIL)
    engine.begin(UserData())
    outcomes = [engine.run(float(now)) for now in range(3)]
    assert "finished" in outcomes
    assert called == []
