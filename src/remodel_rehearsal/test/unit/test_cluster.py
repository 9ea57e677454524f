"""Trials are computed once, whoever dies meanwhile; the physics is scripted here."""

import os
import signal
import socket
import subprocess
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

import pytest
from scripted_trial import CALL, board_of, work

from remodel_production.core.production import Order
from remodel_rehearsal.core.forecast import Change
from remodel_rehearsal.edge import cluster
from remodel_rehearsal.edge.cluster import Job, Rehearsing, connected, done
from remodel_rehearsal.edge.rehearsal_files import RehearsalError, TrialStore, mark_of
from remodel_rehearsal.stack import Rehearsed, Setting
from remodel_run.rehearsal import Failure, Trial
from remodel_work.routes import PlacedWires

WIRES = ("W1", "W2", "W3", "W4")


def job_in(folder):
    setting = Setting(Order("house", "", "house.qet", (), wires=()))
    return Job(setting, {}, str(folder), mark_of(setting, {}, "sources"))


def test_a_board_comes_back_to_the_last_bit(tmp_path):
    store, board = TrialStore(str(tmp_path)), board_of("W2", "W1")
    key = store.put_board(board)
    found = store.board(key)
    assert key == store.put_board(found)
    assert found.occupied == board.occupied
    for name, wire in board.parked.items():
        assert found.parked[name].nodes.tobytes() == wire.nodes.tobytes()
        assert found.parked[name].fixed == wire.fixed
    assert store.put_board(board_of("W1")) != key


def test_a_trial_that_was_made_is_not_made_again(tmp_path, monkeypatch):
    made, documents = [], []

    def rehearsed(setting, wire, seed, board, table, pictures):
        made.append((wire, seed, setting.force_n))
        documents.append(setting.preferences)
        picture = Path(pictures) / "W1-1-whole.png"
        picture.write_bytes(b"picture")
        failure = Failure("InsertCable", "INSERTION_JAMMED", "jammed")
        trial = Trial(wire, seed, True, 2, (failure,), 60.0, picture.name)
        return Rehearsed(trial, (CALL,), board_of(wire), cpu_s=2.0, physics_s=1.0)

    monkeypatch.setattr(cluster, "rehearse_wire", rehearsed)
    job, store = job_in(tmp_path), TrialStore(str(tmp_path))
    empty = store.put_board(PlacedWires())
    first, again = (done(job, "W1", 3, empty) for _ in range(2))
    assert first == again and made == [("W1", 3, 0.0)]
    assert list(store.board(first.board).parked) == ["W1"]
    assert store.picture(first.trial.picture) == b"picture"
    done(job, "W1", 3, first.board)
    done(job, "W1", 3, empty, change=Change("20 N", force_n=20.0))
    done(job, "W1", 3, empty, nominal=True)
    assert len(made) == 4 and made[2] == ("W1", 3, 20.0)
    done(job, "W1", 3, empty, change=Change("inserted at end b first", begin="b"))
    assert documents[:4] == [None] * 4
    (entry,) = documents[4]["require"]
    assert (entry["begin"], entry["at"]) == ("W1", "b")


def test_a_trial_that_breaks_off_is_a_failure_and_no_end_of_the_others(tmp_path, monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(cluster, "rehearse_wire", broken)
    job, store = job_in(tmp_path), TrialStore(str(tmp_path))
    empty = store.put_board(PlacedWires())
    kept = done(job, "W1", 3, empty)
    assert (kept.trial.placed, kept.board) == (False, empty)
    (failure,) = kept.trial.failures
    assert failure.code == "BROKEN_OFF" and "ZeroDivisionError: division by zero" in failure.text
    assert list((tmp_path / "trials").iterdir()) == [], "it is tried again the next time"


@pytest.mark.parametrize("place", ["boards", "trials"])
def test_a_damaged_file_is_named(tmp_path, place):
    store = TrialStore(str(tmp_path))
    (tmp_path / place / "key").write_bytes(b"{")
    with pytest.raises(RehearsalError, match=rf"{place}/key.*remove it"):
        store.board("key") if place == "boards" else store.trial("key")


def test_a_place_that_cannot_be_written_to_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RehearsalError, match="cannot be kept"):
        TrialStore(str(tmp_path / "file"))
    with pytest.raises(RehearsalError, match="cannot be kept"):
        TrialStore("nowhere://states")


def test_a_scheduler_that_is_not_there_is_refused_with_what_to_start():
    with (
        pytest.raises(RehearsalError, match="dask scheduler"),
        connected("tcp://127.0.0.1:9", workers=1),
    ):
        pass


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_no_trial_and_doubles_none(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "planned_wires", lambda _: dict.fromkeys(WIRES, ""))
    monkeypatch.setenv("PYTHONPATH", f"{Path(__file__).parent}:{os.environ['PYTHONPATH']}")
    job, seeds = job_in(tmp_path), range(20)
    with connected("", workers=2) as client:
        before = client.run(os.getpid)

        def kill_one(kept, count, of):
            if count == 20:
                os.kill(next(iter(before.values())), signal.SIGKILL)

        found = Rehearsing(job, seeds, client, kill_one, work=work).trials()
        after = client.run(os.getpid)
    assert Counter((kept.trial.wire, kept.trial.seed) for kept in found) == {
        (wire, seed): 1 for wire in WIRES for seed in seeds
    }
    assert set(after.values()) != set(before.values())
    # Each trial of a wire begins from the board with the wires before it.
    store = TrialStore(job.store)
    lies = {kept.trial.wire: list(store.board(kept.board).parked) for kept in found}
    assert lies == {wire: list(WIRES[: i + 1]) for i, wire in enumerate(WIRES)}
    assert len(list((tmp_path / "trials").iterdir())) == len(WIRES) * (len(seeds) + 1) - 1


def started(stack, *words):
    """Start a process that is killed at the end; return it."""
    process = subprocess.Popen(["dask", *words], stderr=subprocess.DEVNULL, text=True)
    stack.callback(process.wait)
    stack.callback(process.kill)
    return process


@pytest.mark.slow
def test_a_scheduler_that_is_killed_takes_no_trial_with_it(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "planned_wires", lambda _: dict.fromkeys(WIRES, ""))
    monkeypatch.setenv("PYTHONPATH", f"{Path(__file__).parent}:{os.environ['PYTHONPATH']}")
    job, seeds = job_in(tmp_path / "states"), range(20)
    trials = tmp_path / "states" / "trials"

    def rehearse(stack, count_to_kill):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        address = f"tcp://127.0.0.1:{port}"
        words = ("--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
        scheduler = started(stack, "scheduler", *words)
        started(stack, "worker", "--nthreads", "1", "--no-dashboard", address)

        def on_trial(kept, count, of):
            if count == count_to_kill:
                scheduler.kill()

        client = stack.enter_context(connected(address, workers=1))
        return Rehearsing(job, seeds, client, on_trial, work=work).trials()

    with ExitStack() as stack, pytest.raises(RehearsalError, match=r"scheduler.*run the command"):
        rehearse(stack, 20)
    kept = {path.name: path.stat().st_mtime_ns for path in trials.iterdir()}
    assert len(kept) >= 20
    with ExitStack() as stack:
        found = rehearse(stack, 0)
    assert Counter((each.trial.wire, each.trial.seed) for each in found) == {
        (wire, seed): 1 for wire in WIRES for seed in seeds
    }
    assert {path.name: path.stat().st_mtime_ns for path in trials.iterdir()}.items() >= kept.items()
