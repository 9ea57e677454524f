"""What `remodel rehearse` prints and refuses; the physics is tested in remodel_rehearsal."""

import argparse
from contextlib import closing, nullcontext

import msgspec
import pytest
from house import HOUSE

from remodel_planner.commands import rehearse
from remodel_planner.commands.options.common import seeds
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_rehearsal.core.forecast import forecast, with_changes
from remodel_rehearsal.edge.rehearsal_files import KeptTrial
from remodel_run.rehearsal import Failure, Forecast, Trial

JAMMED = Failure("InsertCable", "INSERTION_JAMMED", "end a of W2 stopped 4.0 mm deep")


def found():
    good = [Trial("W1", seed, True, 1, cell_s=60.0) for seed in range(4)]
    bad = [Trial("W2", seed, True, 2, (JAMMED,), 90.0, "abc.png") for seed in range(4)]
    tried = {("W2", "pushed with 20 N"): bad, ("W2", "8 cm longer"): bad}
    return with_changes(forecast(["W2", "W1"], good + bad), tried)


def test_a_forecast_is_a_line_for_each_wire_and_what_to_check():
    printed = rehearse.lines(found())
    assert printed[1].split()[:2] == ["W2", "4"] and "INSERTION_JAMMED" in printed[1]
    assert printed[2].split()[:2] == ["W1", "4"]
    text = "\n".join(printed)
    assert "2.5 min in the cell" in text
    assert "check W2: end a of W2 stopped 4.0 mm deep" in text
    assert "pushed with 20 N" in text and "none of this helps" in text


@pytest.mark.parametrize(
    ("text", "read"), [("7", (7,)), ("0-3", (0, 1, 2, 3)), ("3,7-9,8", (3, 7, 8, 9))]
)
def test_seeds_are_ranges_and_single_ones(text, read):
    assert seeds(text) == read


@pytest.mark.parametrize("text", ["", "a", "3-1", "-1", "1-x", "1,,2"])
def test_what_is_no_seed_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match="such as 0-99"):
        seeds(text)


class Helped:
    """Stands for a rehearsal of W1, which fails unless its other end is inserted first."""

    def __init__(self, *_):
        self.first = {"W1": "a"}

    def trials(self):
        return [self.kept(seed, (JAMMED,)) for seed in range(10)]

    def changed(self, changes):
        return {
            ("W1", change): [self.kept(s, () if change.begin else (JAMMED,)) for s in range(10)]
            for change in changes["W1"]
        }

    def kept(self, seed, failures):
        return KeptTrial(Trial("W1", seed, True, 1 + len(failures), failures), (), "", 1.0, 1.0)


def test_what_helped_is_adopted_and_printed(house, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(rehearse, "Rehearsing", Helped)
    monkeypatch.setattr(rehearse, "connected", lambda *_: nullcontext())
    words = ["house", "--states", str(tmp_path / "states"), "--database", house]
    assert rehearse.main(words) == 0
    assert "adopted" not in capsys.readouterr().out
    assert rehearse.main([*words, "--adopt"]) == 0
    name = "rehearsed: W1 inserted at end b first, 95% at the first attempt in place of 5%"
    assert capsys.readouterr().out.endswith(f"preferences:\n  {name}\n")
    with closing(ProductionDatabase(house)) as opened:
        (entry,) = opened.preferences("house")["require"]
    assert entry == {"name": name, "begin": "W1", "at": "b"}
    assert rehearse.main([*words, "--adopt", "--json"]) == 0
    assert msgspec.json.decode(capsys.readouterr().out, type=Forecast).adopted == (name,)


@pytest.mark.parametrize("other", [["--no-changes"], ["--seed", "1"]])
def test_nothing_is_adopted_without_changes(other):
    with pytest.raises(SystemExit):
        rehearse.main(["house", "--adopt", *other])


@pytest.fixture
def house(database):
    """Return the URL of a database with the order HOUSE."""
    with closing(ProductionDatabase(database)) as made:
        made.add_order(HOUSE)
    return database


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["hose"], "no order hose"),
        (["house", "--seed", "1", "--use-case", "nothing"], "nothing"),
        (["house", "--uncertainty", "none.yaml"], "none.yaml"),
        (["house", "--states", "nowhere://x"], "cannot be kept"),
    ],
)
def test_what_cannot_be_rehearsed_is_refused_before_anything_begins(house, words, said, capsys):
    assert rehearse.main([*words, "--database", house]) == 1
    assert said in capsys.readouterr().err
