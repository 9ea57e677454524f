"""The tables of abilities, error codes and faults, and which abilities a node serves."""

import ast
import copy
import os
from pathlib import Path

import pytest
import yaml

from remodel_states.core.state_source import module_name, state_source
from remodel_states.core.tables import TableError, abilities_from, action_from, chosen_abilities
from remodel_states.edge.exported_tables import (
    abilities_in,
    exporting_packages,
    faults_from,
    read_actions,
    read_cell_limits,
)

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


def test_comments_may_have_quotes_and_backslashes():
    means = 'It is """in""", or \\N near.'
    found, problems = abilities(CrimpFerrule=row(means=means))
    assert not problems
    state = ast.parse(state_source(found["CrimpFerrule"])).body[-1]
    assert "It is '''in''', or \\N near." in ast.get_docstring(state)


def test_a_default_may_have_quotes_and_backslashes():
    parameters = {"ferrule_id": 'a "b" \\ ö', "force": 800.0, "jaw": {"field": "jaw_pose"}}
    found, problems = abilities(CrimpFerrule=row(inputs=["marks"], parameters=parameters))
    assert not problems
    source = state_source(found["CrimpFerrule"])
    (constructor,) = [
        n for n in ast.walk(ast.parse(source)) if getattr(n, "name", "") == "__init__"
    ]
    assert 'a "b" \\ ö' in [ast.literal_eval(default) for default in constructor.args.defaults]


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
        ({"parameters": {"topic": {"field": "force"}}}, "state.parameters: topic cannot be a name"),
        ({"parameters": {"two words": {"field": "force"}}}, "state.parameters: two words cannot"),
        ({"parameters": {"class": {"field": "force"}}}, "state.parameters: class cannot be"),
        ({"parameters": {1: {"field": "force"}}}, "state.parameters: 1 cannot be a name"),
        ({"outputs": {"class": "height"}}, "state.outputs: class cannot be a name in the state's"),
        ({"outputs": {"error_code": "height"}}, "state.outputs: error_code cannot be a name"),
        (
            {"parameters": {"force": "fast"}},
            "state.parameters: the default of force is 'fast'; allowed: a value of type float",
        ),
        ({"parameters": {"force": True}}, "state.parameters: the default of force is True"),
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


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (b"abilities: {} # \xe9", "can't decode byte 0xe9"),
        (b"abilities: 2020-99-99", "month must be in 1..12"),
        (b"abilities: {CrimpFerrule: {1: 2}}", "found 1; missing: errors"),
    ],
)
def test_a_table_that_cannot_be_read_is_reported(tmp_path, text, problem):
    file = tmp_path / "abilities.yaml"
    file.write_bytes(text)
    with pytest.raises(TableError) as error:
        abilities_in("crimping", file, tmp_path, CODES, contract=MSGS)
    assert problem in str(error.value)


def test_an_action_that_cannot_be_read_is_reported(tmp_path):
    (tmp_path / "action").mkdir()
    (tmp_path / "action/Crimp.action").write_bytes(b"\xff")
    with pytest.raises(TableError, match=r"Crimp\.action: 1 problem"):
        read_actions(tmp_path)


def test_a_cell_of_an_endless_name_is_none():
    with pytest.raises(TableError, match="no such cell or file"):
        read_cell_limits("x" * 300)


def test_packages_without_a_package_xml_export_nothing(tmp_path, monkeypatch):
    (tmp_path / "old").mkdir()
    (tmp_path / "old/manifest.xml").write_text("<package/>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{os.environ['ROS_PACKAGE_PATH']}:{tmp_path}")
    assert "old" not in exporting_packages()


def test_each_fault_is_caused_by_an_ability_that_reports_its_code():
    tables = faults_from({"remodel_msgs": [MSGS / "config/faults.yaml"]}, MSGS)
    file = MSGS / "config/abilities.yaml"
    rows = abilities_in("remodel_msgs", file, MSGS, tables.codes, contract=MSGS)
    for fault in tables.faults.values():
        cause = fault["cause"]["interface"]
        errors = rows[cause["ability"]].errors
        if "code" in cause and tables.numbers[cause["code"]] >= 100:
            assert cause["code"] in errors, fault["fault"]


OWN = yaml.safe_load("""\
faults:
  - fault: ferrule_missing
    family: grasping
    codes: [{code: 1000, name: FERRULE_MISSING, meaning: Empty jaw., remedy: Feed ferrules.}]
    severity: recoverable
    symptoms: The jaw closes on nothing.
    first_level: task
    responses: [{do: ask_operator, because: Only a person can feed ferrules.}]
    cause: {interface: {ability: CrimpFerrule, code: FERRULE_MISSING}}
""")


def tables_with(folder, own):
    file = folder / "faults.yaml"
    file.write_text(yaml.safe_dump(own))
    return faults_from({"remodel_msgs": [MSGS / "config/faults.yaml"], "crimping": [file]}, MSGS)


def changed(**fields):
    own = copy.deepcopy(OWN)
    row = own["faults"][0]
    row["codes"][0].update({k: v for k, v in fields.items() if k in row["codes"][0]})
    row.update({k: v for k, v in fields.items() if k not in row["codes"][0]})
    return own


def test_a_package_adds_codes_and_faults_of_its_own(tmp_path):
    tables = tables_with(tmp_path, OWN)
    assert tables.numbers["FERRULE_MISSING"] == 1000
    assert tables.numbers["INSERTION_JAMMED"] == 301
    assert tables.codes["FERRULE_MISSING"].package == "crimping"
    assert list(tables.faults)[-1] == "ferrule_missing"


def test_a_fault_after_another_one_has_its_codes(tmp_path):
    faults = tables_with(tmp_path, OWN).faults
    assert faults["tip_misjudged"]["codes"] == faults["insertion_misaligned"]["codes"]


@pytest.mark.parametrize(
    ("own", "problem"),
    [
        (changed(code=301), "code 301 FERRULE_MISSING of crimping: allowed: 1000 to 9999"),
        (
            changed(name="INSERTION_JAMMED"),
            "code 1000 INSERTION_JAMMED of crimping: INSERTION_JAMMED is 301 INSERTION_JAMMED of "
            "remodel_msgs already",
        ),
        (changed(fault="insertion_jammed"), "fault insertion_jammed: listed twice"),
        (changed(severity="bad"), "severity: found 'bad'; allowed: recoverable, serious"),
        ({**OWN, "fault": []}, "the file: found fault; allowed: abilities, no_fault, faults"),
        (changed(colour="red"), "faults[0]: found colour; allowed: fault, family"),
        (changed(code="x"), "faults[0].codes[0].code: found 'x'; allowed: a value of type integer"),
        (
            {"faults": [{**changed(after={"fault": "none", "times": 2})["faults"][0]}]},
            "faults[0]",
        ),
        ([], "the file: found []; allowed: a value of type object"),
    ],
)
def test_a_faulty_table_is_reported_with_its_file(tmp_path, own, problem):
    with pytest.raises(TableError) as error:
        tables_with(tmp_path, own)
    assert str(tmp_path / "faults.yaml") in str(error.value)
    assert problem in str(error.value)


def test_after_names_a_fault_with_codes(tmp_path):
    own = changed(after={"fault": "none", "times": 2})
    del own["faults"][0]["codes"]
    with pytest.raises(TableError, match=r"after\.fault none is not a fault with codes"):
        tables_with(tmp_path, own)


def test_a_table_that_is_no_yaml_is_reported(tmp_path):
    file = tmp_path / "faults.yaml"
    file.write_text("faults: [")
    with pytest.raises(TableError, match=r"faults\.yaml"):
        faults_from({"remodel_msgs": [file]}, MSGS)


def test_a_table_of_abilities_may_list_faults(tmp_path):
    own = {"abilities": {}, **OWN}
    assert tables_with(tmp_path, own).numbers["FERRULE_MISSING"] == 1000


KNOWN = ["DetectCable", "InsertCable", "PickCable"]


@pytest.mark.parametrize(
    ("abilities", "others", "served"),
    [
        ("", "", KNOWN),
        ("", [], KNOWN),
        ([], "", []),
        ("PickCable, DetectCable", "", ["DetectCable", "PickCable"]),
        (["PickCable"], "", ["PickCable"]),
        ("", "InsertCable", ["DetectCable", "PickCable"]),
        ("InsertCable,PickCable", ["PickCable"], ["InsertCable"]),
        ("PickCable", "PickCable", []),
    ],
)
def test_abilities_are_chosen_by_name(abilities, others, served):
    assert chosen_abilities(KNOWN, abilities, others) == served


@pytest.mark.parametrize(
    ("abilities", "others", "problem"),
    [
        ("Pick", "", "'abilities' names no ability: Pick; there are DetectCable, InsertCable"),
        ("", "PickCabel", "'except' names no ability: PickCabel"),
        (3, "", "'abilities' is 3; allowed: names of abilities"),
    ],
)
def test_a_wrong_name_is_refused(abilities, others, problem):
    with pytest.raises(ValueError, match=problem):
        chosen_abilities(KNOWN, abilities, others)
