"""Events are read from and written to the database as they have always been, byte for byte."""

import json
from pathlib import Path
from typing import get_args

import pytest

from remodel_production.errors import OrderError
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import TABLE
from remodel_supervision.core.runs.events import (
    Event,
    FeedRefused,
    OperationEnded,
    Planned,
    RunBegun,
    data_of,
    event_from,
    kind_of,
)

# One line for each kind, as a development version wrote it before msgspec was used.
RECORDED = Path(__file__).with_name("recorded_events.jsonl").read_text().splitlines()


def test_every_kind_was_recorded():
    assert [json.loads(line)[0] for line in RECORDED] == [k.__name__ for k in get_args(Event)]


def test_every_kind_has_its_row_in_the_table():
    assert set(TABLE) == set(get_args(Event))


@pytest.mark.parametrize("line", RECORDED, ids=lambda line: json.loads(line)[0])
def test_a_recorded_event_is_read_and_written_byte_for_byte(line):
    event = event_from(*json.loads(line))
    assert json.dumps([kind_of(event), data_of(event)]) == line


def test_an_event_has_the_types_of_its_fields():
    assert event_from("Planned", {"tasks": ["W2", "W1"], "because": "x"}) == Planned(
        ("W2", "W1"), "x"
    )
    at_s = event_from("FeedRefused", {"task": "W1", "code": 8, "text": "", "at_s": 4}).at_s
    assert isinstance(at_s, float), "JSON of other programs writes 4.0 as 4"


def test_fields_that_an_older_version_did_not_have_get_their_defaults():
    old = {"order": "house", "use_case": "panel", "cell": "cell", "tasks": ["W1"]}
    assert event_from("RunBegun", old) == RunBegun("house", "panel", "cell", ("W1",))


OPERATION = data_of(OperationEnded("W1", Operation("/A", "InsertCable", "", 0, "", 1.0, 1.0)))


@pytest.mark.parametrize(
    ("kind", "data", "message"),
    [
        ("Nonsense", {}, "there is no event 'Nonsense'; there are RunBegun, "),
        ("Planned", {"tasks": ["W1"], "because": 3}, "Planned is malformed: .*because"),
        ("Planned", {"tasks": "W1", "because": ""}, "Planned is malformed: .*tasks"),
        ("Planned", {"tasks": ["W1"]}, "Planned is malformed: .*because"),
        ("Answered", {"number": 1, "choice": "jump", "by": ""}, "Answered is malformed: .*jump"),
        ("FeedRefused", {**data_of(FeedRefused("", 1, "", 0.0)), "code": True}, "FeedRefused is"),
        ("Blocked", {"because": "x", "more": 1}, "unknown field more"),
        (
            "OperationEnded",
            {**OPERATION, "operation": {**OPERATION["operation"], "more": 1}},
            "unknown field more",
        ),
    ],
)
def test_what_is_no_event_is_refused(kind, data, message):
    with pytest.raises(OrderError, match=message):
        event_from(kind, data)
