"""Rows of abilities: mistakes are found before anything is generated from them."""

from pathlib import Path

import pytest

from remodel_states.core.state_source import module_name, state_source
from remodel_states.core.tables import TableError, abilities_from, action_from
from remodel_states.edge.exported_tables import abilities_in, faults_from

MSGS = Path(__file__).parents[3] / "remodel_msgs"
CODES = ("FERRULE_MISSING",)
CRIMP = action_from(
    "CrimpFerrule",
    """\
# CrimpFerrule: close the jaw on a ferrule
#
# Goal
string id
string ferrule_id   # which ferrule
float64 force       # [N] of the jaw
geometry_msgs/PoseStamped jaw_pose  # of the jaw; any frame
geometry_msgs/Point[] marks  # on the wire
float64 timeout     # [s]
---
string id
bool success
string message
float64 elapsed_time
int16 error_code
string error_message
float64 height      # [m] of the crimp
---
string id
""",
)


def row(**changes):
    state = {
        "outcome": "crimped",
        "means": "The ferrule holds.",
        "inputs": ["ferrule_id", "marks"],
        "parameters": {"force": 800.0, "jaw": {"field": "jaw_pose"}},
        "outputs": {"crimp_height": "height"},
        "timeout_s": 20,
    }
    return {"errors": ["FERRULE_MISSING"], "fake": {"height": 0.002}, "state": {**state, **changes}}


def abilities(**rows):
    return abilities_from("crimping", {"abilities": rows}, {"CrimpFerrule": CRIMP}, CODES)


def test_a_row_and_its_action_make_an_ability():
    found, problems = abilities(CrimpFerrule=row())
    assert not problems
    crimp = found["CrimpFerrule"]
    assert crimp.topic == "remodel_abilities/crimpferrule"
    assert crimp.action.title == "close the jaw on a ferrule"
    assert [p.name for p in crimp.state.parameters] == ["jaw", "force"]
    assert crimp.state.outputs["crimp_height"].text == "[m] of the crimp"


def test_its_state_sends_every_field_and_writes_the_outputs():
    found, _ = abilities(CrimpFerrule=row())
    source = state_source(found["CrimpFerrule"])
    compile(source, "crimp_ferrule_state.py", "exec")
    assert "def __init__(self, jaw, force=800.0, timeout_s=20.0, topic=" in source
    assert "jaw_pose=panel_pose(self._jaw)" in source
    assert "userdata.crimp_height = self._call.result.height" in source
    assert "-- jaw  list  [x, y, z, yaw] in the panel frame [m, rad], of the jaw." in source
    assert module_name("CrimpFerrule") == "crimp_ferrule_state"


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"inputs": ["ferrule"]}, "state.inputs: ferrule is not a field of the goal; there are: "),
        ({"inputs": ["marks"]}, "state: field ferrule_id of the goal is given 0 times"),
        (
            {"inputs": ["ferrule_id", "force", "marks"]},
            "state: field force of the goal is given 2 times; allowed: once",
        ),
        ({"outputs": {"x": "width"}}, "state.outputs: width is not a field of the result"),
        (
            {"inputs": ["ferrule_id"], "parameters": {"marks": None}},
            "state.parameters: marks is of type geometry_msgs/Point[]; allowed: string, bool",
        ),
    ],
)
def test_a_row_that_does_not_fit_its_action_is_reported(changes, problem):
    _, problems = abilities(CrimpFerrule=row(**changes))
    assert f"abilities.CrimpFerrule.{problem}" in "\n".join(problems)


def test_unknown_actions_codes_and_results_are_reported():
    _, problems = abilities(Crimp=row())
    assert problems == ["abilities.Crimp: no action/Crimp.action; there are: CrimpFerrule"]
    _, problems = abilities(CrimpFerrule={"errors": ["NO_FERRULE"], "fake": {"size": 1}})
    assert problems == [
        "abilities.CrimpFerrule.errors: NO_FERRULE is not an error code; list it in a faults.yaml",
        "abilities.CrimpFerrule.fake: size is not a field of the result; there are: height",
    ]


def test_a_table_of_another_form_is_reported(tmp_path):
    file = tmp_path / "abilities.yaml"
    file.write_text("abilities: {CrimpFerrule: {colour: red}}")
    with pytest.raises(TableError) as error:
        abilities_in("crimping", file, tmp_path, CODES, contract=MSGS)
    assert error.value.problems == (
        "abilities.CrimpFerrule: found colour; missing: errors",
        "abilities.CrimpFerrule.colour: found 'red'; allowed: text that matches ^#[0-9a-f]{6}$",
    )


def test_each_fault_is_caused_by_an_ability_that_reports_its_code():
    tables = faults_from({"remodel_msgs": [MSGS / "config/faults.yaml"]}, MSGS)
    file = MSGS / "config/abilities.yaml"
    rows = abilities_in("remodel_msgs", file, MSGS, tables.codes, contract=MSGS)
    for fault in tables.faults.values():
        cause = fault["cause"]["interface"]
        errors = rows[cause["ability"]].errors
        if "code" in cause and tables.numbers[cause["code"]] >= 100:
            assert cause["code"] in errors, fault["fault"]
