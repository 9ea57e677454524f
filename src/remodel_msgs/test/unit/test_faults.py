"""The table of faults is safe to follow. Reading it checks its form (remodel_states)."""

import re
from pathlib import Path

import pytest
import yaml

CONFIG = Path(__file__).parents[2] / "config"
TABLES = [yaml.safe_load((CONFIG / f"{name}.yaml").read_text()) for name in ("faults", "abilities")]
FAULTS = [row for table in TABLES for row in table.get("faults", [])]
ACTIONS = {file.stem for file in CONFIG.parent.glob("action/*.action")}

FAMILIES = {"perception", "grasping", "control", "modelling"}
LASTING = {"set_aside", "ask_operator", "stop"}

# Rules of safety. A behavior pushes up to 3 times by itself, unless it leaves the fault to task or
# use case (place_connector.xml); each response that is not lasting starts the task once more.
INSIDE = {"action", "behavior"}
PUSHES_OF_A_BEHAVIOR = 3
MOST_PUSHES = {"insertion_jammed": 2}
MOST_PUSHES_OTHERWISE = 9
PUSHING = {
    "tip_misjudged",
    "slipped",
    "insertion_misaligned",
    "insertion_jammed",
    "insufficient_force",
    "pulled_out",
}
# [N] What the fingers hold without slipping; a fifth of it is kept in reserve.
GRIP_HOLDS = 25.0
BY_NAME = {row["fault"]: row for row in FAULTS}


def responses(name):
    return [response["do"] for response in BY_NAME[name]["responses"]]


def test_there_are_enough_kinds_in_four_families():
    assert len(FAULTS) >= 16
    assert {row["family"] for row in FAULTS} == FAMILIES


def test_responses_end_for_good():
    for row in FAULTS:
        *others, last = row["responses"]
        assert last["do"] in LASTING, row["fault"]
        assert not {response["do"] for response in others} & LASTING, row["fault"]


def test_only_a_changed_retry_states_a_change():
    for row in FAULTS:
        for response in row["responses"]:
            assert ("change" in response) == (response["do"] == "retry_with"), row["fault"]


def test_each_response_has_a_reason_of_its_own_in_one_sentence():
    for row in FAULTS:
        reasons = [response["because"] for response in row["responses"]]
        found = [because for because in reasons if not re.fullmatch(r"[A-Z][^.!?]{20,}\.", because)]
        assert found == [], row["fault"]
        assert len(set(reasons)) == len(reasons), row["fault"]


def test_nothing_moves_again_without_a_new_observation_or_a_change():
    assert [name for name in BY_NAME if "retry" in responses(name)] == []


def test_a_serious_fault_is_observed_before_anything_else_moves():
    serious = [row for row in FAULTS if row["severity"] == "serious"]
    assert serious
    for row in serious:
        first = responses(row["fault"])[0]
        assert first in LASTING | {"look_again"} or row["family"] == "modelling", row["fault"]


@pytest.mark.parametrize("name", ["motion_blocked", "extraction_stuck", "cell_contested"])
def test_what_only_a_person_can_judge_is_left_to_one(name):
    assert responses(name) == ["ask_operator"]


@pytest.mark.parametrize("name", ["motion_blocked", "server_hung", "cell_contested"])
def test_where_the_next_task_would_be_as_dangerous_an_unattended_run_stops(name):
    assert BY_NAME[name]["unattended"] == "stop"


@pytest.mark.parametrize("name", sorted(PUSHING))
def test_a_terminal_is_pushed_against_only_so_often(name):
    row = BY_NAME[name]
    *again, _ = row["responses"]
    starts = 1 + sum(response.get("times", 1) for response in again)
    each = PUSHES_OF_A_BEHAVIOR if row["first_level"] in INSIDE else 1
    assert starts * each <= MOST_PUSHES.get(name, MOST_PUSHES_OTHERWISE)


@pytest.mark.parametrize("name", ["server_lost", "server_hung", "result_late"])
def test_whatever_a_server_left_open_is_observed_first(name):
    assert responses(name)[0] == "look_again"


@pytest.mark.parametrize(
    "name",
    [
        "component_not_found",
        "component_occluded",
        "component_displaced",
        "component_missing",
        "two_cables_grasped",
        "insertion_jammed",
        "extraction_stuck",
        "snagged",
        "motion_blocked",
        "result_late",
    ],
)
def test_no_wire_is_scrapped_for_what_it_did_not_cause_or_while_it_hangs_on_something(name):
    assert "new_part" not in responses(name)


def test_no_force_exceeds_what_the_grip_holds():
    for row in FAULTS:
        for response in row["responses"]:
            bound = response.get("change", {}).get("force_limit", {}).get("at_most", 0.0)
            assert bound <= 0.8 * GRIP_HOLDS, row["fault"]


def test_each_fault_can_be_caused():
    for row in FAULTS:
        interface = row["cause"]["interface"]
        assert interface["ability"] in ACTIONS, row["fault"]
        assert ("code" in interface) != ("behaves" in interface), row["fault"]
        source = BY_NAME[row["after"]["fault"]] if "after" in row else row
        names = [code["name"] for code in source["codes"]]
        assert interface.get("code", names[0]) in names, row["fault"]
