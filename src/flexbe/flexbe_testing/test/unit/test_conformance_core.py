"""The parts of engine_conformance that need no engine."""

import ast
from pathlib import Path
from types import SimpleNamespace

import pytest

from flexbe_testing.core.conformance.scenario import (
    Finding,
    Part,
    Scenario,
    UnknownScenarioError,
    Verdict,
    agrees,
    as_json,
    checksum,
    chosen,
    initial,
    shown,
    successor,
    table,
)

PACKAGE = Path(__file__).parents[2]
JUDGE = PACKAGE / "src" / "flexbe_testing"
FEEDBACK = SimpleNamespace(command="lock", args=("/A", "/A"), __slots__=("command", "args"))

SCENARIOS = [
    Scenario(name, f"what {name} requires", "2.2", lambda bench: None)
    for name in ("sync", "attach", "repeat")
]
TREE = {
    part.path: part
    for part in (
        Part("", ("Box", "End"), ("finished",), ()),
        Part("/Box", ("In", "Out"), ("ok",), ("End",)),
        Part("/Box/In", (), ("done", "again"), ("Out", "In")),
        Part("/Box/Out", (), ("done",), ("ok",)),
        Part("/End", (), ("done", "lost"), ("finished", "Nowhere")),
    )
}


def test_the_judge_imports_nothing_of_an_engine():
    files = [file for file in JUDGE.rglob("*.py") if "conformance" in file.parts]
    assert len(files) > 10
    for file in [*files, PACKAGE / "nodes" / "engine_conformance"]:
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in getattr(node, "names", [])] + [
                getattr(node, "module", "")
            ]
            tops = {str(name).split(".")[0] for name in names}
            assert not tops & {"flexbe_core", "flexbe_onboard", "flexbe_mirror"}, file


def test_the_behaviors_use_only_the_public_interface():
    files = list((PACKAGE / "conformance").rglob("*.py"))
    assert len(files) > 10
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("flexbe_core"):
                assert node.module in ("flexbe_core", "flexbe_core.proxy"), file


def test_checksums_are_those_of_stock():
    assert checksum("") == 1
    assert checksum("Wikipedia") == 0x11E60398
    assert checksum("x" * 100_000) < 2**31


def test_messages_agree_in_the_fields_that_are_expected():
    assert agrees(FEEDBACK, {"command": "lock"})
    assert agrees(FEEDBACK, {"args": ["/A", "/A"]})
    assert not agrees(FEEDBACK, {"command": "lock", "args": ["/A", ""]})
    assert shown(FEEDBACK, {"args": []}) == "{args: ['/A', '/A']}"
    assert shown(FEEDBACK) == "{command: 'lock', args: ['/A', '/A']}"


def test_a_structure_says_what_follows():
    assert initial(TREE) == "/Box/In"
    assert successor(TREE, "/Box/In", 0) == "/Box/Out"
    assert successor(TREE, "/Box/In", 1) == "/Box/In"
    assert successor(TREE, "/Box/Out", 0) == "/End"
    assert successor(TREE, "/End", 0) is None


def test_a_structure_without_what_follows_is_refused():
    with pytest.raises(ValueError, match="leads to 'Nowhere', which is not there"):
        successor(TREE, "/End", 1)
    with pytest.raises(LookupError):
        successor(TREE, "/End", 2)


def test_scenarios_are_chosen_by_name_and_keep_their_order():
    assert chosen(SCENARIOS, []) == SCENARIOS
    assert [item.name for item in chosen(SCENARIOS, ["repeat", "sync"])] == ["sync", "repeat"]
    with pytest.raises(UnknownScenarioError, match="no scenario 'atach'; near it: attach"):
        chosen(SCENARIOS, ["atach"])


def test_the_table_has_verdicts_reasons_and_a_count():
    verdicts = (Verdict.PASS, Verdict.FAIL, Verdict.NOT_JUDGED)
    found = [
        Finding(scenario, verdict, "" if verdict is Verdict.PASS else "a reason")
        for scenario, verdict in zip(SCENARIOS, verdicts, strict=True)
    ]
    lines = table(found).splitlines()
    assert lines[0].split() == ["scenario", "section", "verdict", "required"]
    assert lines[2].split(maxsplit=3) == ["sync", "2.2", "pass", "what sync requires"]
    assert lines[3].endswith("what attach requires | a reason")
    assert lines[-1] == "1 pass, 1 FAIL, 1 not judged"
    assert '"verdict": "FAIL"' in as_json(found)
