"""Tables of error codes and faults: those of the workspace, and ones that contradict themselves."""

import copy
from pathlib import Path

import pytest
import yaml

from remodel_states.core.tables import TableError
from remodel_states.edge.exported_tables import faults_from

MSGS = Path(__file__).parents[3] / "remodel_msgs"
OWN = {
    "faults": [
        {
            "fault": "ferrule_missing",
            "family": "grasping",
            "codes": [
                {
                    "code": 1000,
                    "name": "FERRULE_MISSING",
                    "meaning": "The jaw is empty.",
                    "remedy": "Feed ferrules.",
                }
            ],
            "severity": "recoverable",
            "symptoms": "The jaw closes on nothing.",
            "first_level": "task",
            "responses": [{"do": "ask_operator", "because": "Only a person can feed ferrules."}],
            "cause": {"interface": {"ability": "CrimpFerrule", "code": "FERRULE_MISSING"}},
        }
    ]
}


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
