"""What stands for a trial in workers of a cluster, which import it by its name."""

import time

import numpy as np

from remodel_rehearsal.edge.rehearsal_files import KeptTrial, TrialStore, trial_key
from remodel_run.rehearsal import RehearsedCall, Trial
from remodel_work.panel import WireEnd
from remodel_work.routes import ParkedWire, PlacedWires

CALL = RehearsedCall("InsertCable", {"section_mm2": 1.5}, 301, 4.0, {"force_limit": 8.0})


def board_of(*wires):
    nodes = np.arange(12.0).reshape(4, 3) / 7
    return PlacedWires(
        {wire: ParkedWire(nodes, frozenset(WireEnd)) for wire in wires},
        {("Q1", wire): (wire, WireEnd.A) for wire in wires},
    )


def work(job, wire, seed, board, nominal=False, change=None):
    """Stand for `done`: place a wire, a little later."""
    store = TrialStore(job.store)
    key = trial_key(job.mark, wire, seed, board, f"{nominal}")
    kept = store.trial(key)
    if kept is None:
        lies = store.board(board)
        end_s = time.monotonic() + 0.05
        while time.monotonic() < end_s:
            pass
        after = store.put_board(board_of(*lies.parked, wire))
        kept = KeptTrial(Trial(wire, seed, True, 1), (CALL,), after, 1.0, 1.0)
        store.put_trial(key, kept)
    return kept
