"""What the events of a run come to; no physics."""

from types import SimpleNamespace

import pytest

from remodel_rehearsal import stack
from remodel_rehearsal.stack import Outcome, Setting
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import OperationEnded, Part, TaskBegun
from remodel_work.routes import PlacedWires

BEGUN = TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", chart="", at_s=1.0)
JAM = Operation("/Insert", "InsertCable", "failed", 301, text="jammed", ended_s=2.0, elapsed_s=1.0)
GOOD = Operation("/Fix", "FixCable", "fixed", 0, text="fixed", ended_s=3.0, elapsed_s=1.0)


def rehearsed(monkeypatch, *events, placed=()):
    state = SimpleNamespace(ended=SimpleNamespace(because="the panel is refused"))
    after = PlacedWires({"W1": None})
    outcome = Outcome(state, events, frozenset(placed), (), after, cell_s=60.0)
    monkeypatch.setattr(stack, "carry_out", lambda *_, **__: outcome)
    before = PlacedWires()
    found = stack.rehearse_wire(Setting(None), "W1", 3, before, {})
    return found, found.board is (after if placed else before)


def test_a_wire_without_a_failed_ability_is_placed_at_once(monkeypatch):
    found, lies_as_it_should = rehearsed(
        monkeypatch, BEGUN, OperationEnded("W1", GOOD), placed=["W1"]
    )
    assert found.trial.at_once and lies_as_it_should


def test_a_failure_that_was_mended_is_kept(monkeypatch):
    operations = (OperationEnded("W1", JAM), OperationEnded("W1", GOOD))
    found, _ = rehearsed(monkeypatch, BEGUN, *operations, placed=["W1"])
    assert found.trial.placed and not found.trial.at_once
    assert [(each.ability, each.code) for each in found.trial.failures] == [
        ("InsertCable", "INSERTION_JAMMED")
    ]


@pytest.mark.parametrize("events", [(), (BEGUN, OperationEnded("W1", GOOD))])
def test_a_wire_that_is_not_placed_has_a_reason_though_no_ability_failed(monkeypatch, events):
    found, lies_as_it_should = rehearsed(monkeypatch, *events)
    (failure,) = found.trial.failures
    assert (failure.code, failure.text) == ("NOT_PLACED", "the panel is refused")
    assert lies_as_it_should
