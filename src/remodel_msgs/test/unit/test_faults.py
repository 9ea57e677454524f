"""The table of faults fits the table of error codes, and says all that it must."""

import importlib.util
from collections import Counter
from pathlib import Path

import pytest
import yaml

CONFIG = Path(__file__).parents[2] / "config"
FAULTS = yaml.safe_load((CONFIG / "faults.yaml").read_text())
CODES = {row["name"]: row for row in yaml.safe_load((CONFIG / "error_codes.yaml").read_text())}
ACTIONS = {file.stem for file in CONFIG.parent.glob("action/*.action")}

FAMILIES = {"perception", "grasping", "control", "modelling"}
FIELDS = {"fault", "family", "codes", "severity", "symptoms", "first_level", "responses", "cause"}
LASTING = {"set_aside", "ask_operator", "stop"}
RESPONSES = LASTING | {"retry", "retry_with", "look_again", "other_method", "new_part", "replan"}
NO_FAULTS = {"NONE", "PREEMPTED"}


def test_there_are_enough_kinds_in_four_families():
    assert len(FAULTS) >= 16
    assert {row["family"] for row in FAULTS} == FAMILIES
    assert max(Counter(row["fault"] for row in FAULTS).values()) == 1


def test_every_code_belongs_to_a_fault():
    assert {code for row in FAULTS for code in row["codes"]} == set(CODES) - NO_FAULTS


def test_a_code_without_history_belongs_to_one_fault():
    plain = Counter(code for row in FAULTS if "after" not in row for code in row["codes"])
    assert set(plain) == set(CODES) - NO_FAULTS
    assert max(plain.values()) == 1


@pytest.mark.parametrize("row", FAULTS, ids=lambda row: row["fault"])
def test_each_fault_is_whole(row):
    assert FIELDS <= set(row) <= FIELDS | {"after"}
    assert row["symptoms"].endswith(".")
    assert row["severity"] in {"recoverable", "serious"}
    if "after" not in row:
        for code in row["codes"]:
            assert CODES[code]["severity"] == row["severity"], code
            assert CODES[code]["first_level"] == row["first_level"], code


@pytest.mark.parametrize("row", FAULTS, ids=lambda row: row["fault"])
def test_its_responses_end_for_good(row):
    *others, last = row["responses"]
    assert {response["do"] for response in row["responses"]} <= RESPONSES
    assert last["do"] in LASTING
    assert not {response["do"] for response in others} & LASTING
    for response in row["responses"]:
        assert ("change" in response) == (response["do"] == "retry_with")


@pytest.mark.parametrize("row", FAULTS, ids=lambda row: row["fault"])
def test_it_can_be_caused(row):
    interface = row["cause"]["interface"]
    assert interface["ability"] in ACTIONS
    assert ("code" in interface) != ("behaves" in interface)
    assert interface.get("code", row["codes"][0]) in row["codes"]
    assert interface.get("behaves", "hangs") in {"hangs", "dies", "contradicts"}


def test_the_document_is_of_the_tables_as_they_are():
    tool = Path(__file__).parents[4] / "tools" / "draw_faults.py"
    spec = importlib.util.spec_from_file_location("draw_faults", tool)
    draw_faults = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(draw_faults)
    assert draw_faults.DOCUMENT.read_text() == draw_faults.drawn(), "run tools/draw_faults.py"
