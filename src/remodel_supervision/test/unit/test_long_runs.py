"""A long run is resumed from its snapshot, and takes little room."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from house import owner_of
from long_run import long_order, long_run
from sqlalchemy import text

from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import RecordLostError
from remodel_supervision.core.runs import state as run_state
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Interrupted
from remodel_supervision.core.runs.state import RunState, Stage, snapshot_of, state_from
from remodel_supervision.edge import run_log
from remodel_supervision.edge.run_log import RunLog

BENCHMARKS = Path(__file__).parents[4] / "benchmarks"
TASKS = 15
SNAPSHOT_EVERY = 80


class Kept:
    """A long run that was cut short, in a database."""

    def __init__(self, url):
        self.database = ProductionDatabase(url)
        order = long_order(TASKS)
        self.database.add_order(order)
        self.owner = owner_of(self.database)
        self.log = RunLog(self.database)
        begun, *self.events = long_run(order)
        self.run, self.begun = self.log.begin(begun, self.owner)
        self.state = state_after([self.begun])
        for event in self.events:
            self.state = self.log.append(self.run, event, self.state, self.owner)

    def change(self, statement):
        with self.database.transaction() as connection:
            connection.execute(text(statement))


@pytest.fixture
def kept(url, monkeypatch):
    monkeypatch.setattr(run_log, "SNAPSHOT_EVERY", SNAPSHOT_EVERY)
    kept = Kept(url)
    assert 2 < len(kept.events) / SNAPSHOT_EVERY < 3
    yield kept
    kept.database.close()


def resumable(state: RunState) -> RunState:
    """Return what a resumed run needs of a state."""
    tasks = {
        name: replace(task, operations=()) if task.stage is Stage.DONE else task
        for name, task in state.tasks.items()
    }
    return replace(state, tasks=tasks)


def test_a_run_is_resumed_from_its_snapshot_and_what_came_after(kept):
    assert [each.event for each in kept.log.events(kept.run)] == [kept.begun, *kept.events]
    first = SNAPSHOT_EVERY * 2
    assert [each.event for each in kept.log.events(kept.run, first)] == kept.events[first - 1 :]
    # What the snapshot covers is not read again.
    kept.change(f"DELETE FROM run_events WHERE position < {first}")
    assert resumable(kept.log.state(kept.run)) == resumable(kept.state)
    kept.change("UPDATE runs SET events = events + 1")
    with pytest.raises(
        RecordLostError, match=rf"of run 1 from number {first} on; restore a backup"
    ):
        kept.log.state(kept.run)


def test_a_snapshot_of_another_version_is_not_read(kept, monkeypatch):
    monkeypatch.setattr(run_state, "_form", lambda: "2-another")
    assert kept.log.state(kept.run) == kept.state
    state = kept.log.append(kept.run, Interrupted("killed"), kept.state, kept.owner)
    assert kept.log.state(kept.run) == state


def test_there_is_one_snapshot_of_a_run(kept):
    with kept.database.reading() as connection:
        rows = connection.execute(text("SELECT run_id, events FROM run_snapshots")).all()
    assert [tuple(row) for row in rows] == [(kept.run, SNAPSHOT_EVERY * 2)]


def test_what_a_snapshot_says_is_checked():
    data = snapshot_of(RunState(order="house"))
    assert state_from(data) == RunState(order="house")
    assert state_from({**data, "state": {"order": 7}}) is None
    assert state_from({**data, "tasks": [{}]}) is None
    assert state_from("x") is None


def test_another_process_reads_a_snapshot():
    code = "from remodel_supervision.core.runs import state as f; print(f._form())"
    other = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=60
    )
    assert other.stdout.strip() == run_state._form()


def test_the_benchmark_measures(monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(BENCHMARKS / "supervision"))
    import scale

    monkeypatch.setattr(sys, "argv", ["scale.py", "--tasks", "40"])
    monkeypatch.setattr(scale, "MEASURED", 20)
    assert scale.main() == 0
    assert "load the state" in capsys.readouterr().out
