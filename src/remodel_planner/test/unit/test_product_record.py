"""What was done to a product is exported: by which run, attempt, end and force."""

import csv
import io
import json

import pytest
from house import HOUSE, owner_of

from remodel_planner.commands import product
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_run.progress import Answer
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    Ending,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    RunEnded,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.edge.run_log import RunLog

AT_B = (("component_id", "Q2"), ("terminal_id", "T1"))
INSERTED = Operation(
    "/Connect b/InsertCable",
    "InsertCable",
    "inserted",
    0,
    text="seated, at 6.5 N",
    ended_s=9.0,
    elapsed_s=2.0,
    goal_id="17:be-1",
    parameters=(("cable_id", "W1"), ("cable_end", "b"), *AT_B, ("force_limit", "8.0")),
    measurements=(("depth", "0.009"), ("peak_force", "6.5")),
)
FIXED = Operation(
    "/Connect b/FixCable", "FixCable", "fixed", 0, "", 11.0, 1.0, "17:be-2", parameters=AT_B
)
EVENTS = (
    Planned(("W1", "W2"), ""),
    TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", chart="<chart/>", at_s=1.0),
    OperationEnded("W1", INSERTED),
    OperationEnded("W1", FIXED),
    TaskEnded("W1", "failed", 12.0, False),
    Asked(1, "W1", "W1 failed", (Answer.MARK_DONE,)),
    Answered(1, Answer.MARK_DONE, "ann"),
    RunEnded(Ending.STOPPED, ""),
)


@pytest.fixture
def url(tmp_path):
    url = f"sqlite:///{tmp_path}/production.sqlite"
    database = ProductionDatabase(url)
    database.add_order(HOUSE)
    log, owner = RunLog(database), owner_of(database)
    for again in (False, True, False):
        begun = RunBegun("house", "cabinet", "cell", ("W1", "W2"))
        run, begun = log.begin(begun, owner, again=again)
        state = state_after([begun])
        for event in EVENTS:
            state = log.append(run, event, state, owner)
    database.close()
    return url


def test_a_products_record_is_that_of_all_its_runs_and_of_no_other_product(url, capsys):
    assert product.main(["house-0002", "--database", url]) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert [(row["run"], row["ability"]) for row in rows] == [
        (run, ability) for run in "23" for ability in ("InsertCable", "FixCable", "operator")
    ]
    inserted, fixed, answered = rows[:3]
    wanted = {
        "serial": "house-0002",
        "cell": "cell",
        "ended_s": "9.0",
        "elapsed_s": "2.0",
        "task": "W1",
        "attempt": "1",
        "part": "whole",
        "behavior": "Place Wire W1",
        "state_path": "/Connect b/InsertCable",
        "end": "b",
        "goal_id": "17:be-1",
        "result": "inserted",
        "error_code": "0",
        "text": "seated, at 6.5 N",
        "force_limit_n": "8.0",
        "peak_force_n": "6.5",
    }
    assert {name: inserted[name] for name in wanted} == wanted
    assert json.loads(inserted["parameters"]) == dict(INSERTED.parameters)
    assert json.loads(inserted["measurements"]) == dict(INSERTED.measurements)
    assert inserted["kept_at"].endswith("+00:00")
    assert fixed["end"] == "b", "by the terminal that its end belongs in"
    assert (answered["result"], answered["task"]) == ("mark_done", "W1")
    assert answered["text"] == "ann answered question 1: W1 failed"


def test_a_products_record_is_json_in_a_file(url, tmp_path, capsys):
    file = tmp_path / "house.json"
    arguments = ["house-0001", "--format", "json", "--output", str(file), "--database", url]
    assert product.main(arguments) == 0
    assert capsys.readouterr().out == ""
    found = json.loads(file.read_text(encoding="utf-8"))
    assert (found["format"], found["serial"]) == ("remodel-product-1", "house-0001")
    first = found["entries"][0]
    assert (first["force_limit_n"], first["parameters"]["cable_id"]) == (8.0, "W1")
    assert found["entries"][2]["ended_s"] is None


@pytest.mark.parametrize("serial", ["house-0009", ""])
def test_an_unknown_product_is_reported_with_those_there_are(url, serial, capsys):
    assert product.main([serial, "--database", url]) == 1
    error = capsys.readouterr().err
    assert f"there is no product '{serial}'; the last ones are: house-0001, house-0002" in error
