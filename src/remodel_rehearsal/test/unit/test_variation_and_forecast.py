"""What is drawn for a seed, and what trials say."""

import msgspec
import numpy as np
import pytest

from remodel_rehearsal.core.forecast import brier_score, forecast, share
from remodel_rehearsal.core.variation import QUANTITIES, Uncertain, vary
from remodel_rehearsal.edge.rehearsal_files import RehearsalError, read_uncertainty
from remodel_run.rehearsal import Failure, Trial

JAMMED = Failure("InsertCable", "INSERTION_JAMMED", "stopped 4 mm deep")
LOST = Failure("DetectCable", "CABLE_NOT_FOUND", "not seen")


@pytest.fixture(scope="module")
def table():
    return read_uncertainty()


def test_a_seed_draws_the_same_and_another_seed_something_else(table):
    first, again, other = (vary(table, seed, ["overhead"], ["Q1"]) for seed in (3, 3, 4))
    assert first == again
    assert first.factors != other.factors
    assert first.devices["Q1"] != other.devices["Q1"]


def test_each_quantity_has_chance_of_its_own(table):
    some = vary(table, 3, [], ["Q1"])
    more = vary(table, 3, ["overhead"], ["Q2", "Q1"])
    assert some.devices["Q1"] == more.devices["Q1"]
    assert some.factors == more.factors


def test_what_is_drawn_keeps_to_the_table(table):
    for name, each in table.items():
        drawn = [each.draw(np.random.default_rng(seed)) for seed in range(400)]
        assert min(drawn) >= each.at_least and max(drawn) <= each.at_most, name
        assert len(set(drawn)) > 100, name
        assert abs(np.median(drawn) - each.middle) < each.spread, name


@pytest.mark.parametrize("change", [{"spread": -1.0}, {"at_least": 1.5}])
def test_a_quantity_that_cannot_be_drawn_is_refused(change):
    fields = {"unit": "", "meaning": "m", "spread": 0.1, "at_least": 0.5, "at_most": 2.0}
    with pytest.raises(ValueError, match=r"spread|both sides"):
        Uncertain(**fields | {"origin": "o"} | change)


def test_a_file_replaces_single_quantities(tmp_path, table):
    own = tmp_path / "own.yaml"
    own.write_text("light: {spread: 0.0, origin: our lamps}\n")
    found = read_uncertainty(own)
    assert found["light"].spread == 0.0 and found["light"].origin == "our lamps"
    assert {**found, "light": table["light"]} == table
    assert set(found) == set(QUANTITIES)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("lihgt: {spread: 0.1}", "lihgt"),
        ("light: {spread: wide}", "spread"),
        ("light: {sperad: 0.1}", "sperad"),
        ("light: {spread: -1}", "light.*0 or more"),
        ("[1]", "quantities"),
        ("light: {", "light"),
    ],
)
def test_a_malformed_file_is_refused_with_its_place(tmp_path, text, said):
    own = tmp_path / "own.yaml"
    own.write_text(text)
    with pytest.raises(RehearsalError, match=f"(?s)own.yaml.*{said}"):
        read_uncertainty(own)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(RehearsalError, match=r"none\.yaml"):
        read_uncertainty(tmp_path / "none.yaml")


def trials_of(wire, *outcomes):
    return [
        Trial(wire, seed, placed, attempts=1 + len(failures), failures=failures, cell_s=50.0 + seed)
        for seed, (placed, failures) in enumerate(outcomes)
    ]


def test_a_forecast_counts_first_attempts_and_recoveries():
    good, mended, lost = (True, ()), (True, (JAMMED,)), (False, (LOST, JAMMED))
    found = forecast(
        ["W2", "W1", "W9"],
        trials_of("W1", good, good) + trials_of("W2", good, mended, lost, mended),
    )
    second, first = found.wires
    assert (second.wire, first.wire) == ("W2", "W1")
    assert second.failure == JAMMED and first.failure is None
    assert second.at_once.mean == pytest.approx(1.5 / 5)
    assert second.placed.mean == pytest.approx(3.5 / 5)
    assert found.all_at_once == pytest.approx(second.at_once.mean * first.at_once.mean)
    assert [wire.wire for wire in found.failing] == ["W2"]
    mean, low, high = found.cell_s
    assert 100.0 <= low <= mean <= high <= 104.0


def test_an_attempt_that_recovers_inside_its_chart_is_not_at_once():
    (trial,) = trials_of("W1", (True, (JAMMED,)))
    assert not msgspec.structs.replace(trial, attempts=1).at_once


def test_no_number_of_trials_makes_certain():
    assert 0.9 < share(100, 100).low < share(100, 100).mean < 1.0
    wide, narrow = share(1, 2), share(50, 100)
    assert narrow.high - narrow.low < wide.high - wide.low


def test_no_trials_are_no_forecast():
    assert forecast(["W1"], []).wires == ()


def test_the_brier_score_prefers_who_knows():
    outcomes = [("W1", True), ("W2", False)]
    assert brier_score({"W1": 1.0, "W2": 0.0}, outcomes) == 0.0
    assert brier_score({"W1": 0.5, "W2": 0.5}, outcomes) == 0.25
