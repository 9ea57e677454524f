"""An order rehearsed with many seeds, on all cores of a machine or on a cluster of Dask.

Each wire is a task of its own, from a board that is kept: the order is carried out once as the
model has it, wire by wire, and the trials of a wire begin as soon as the board before it is there.
Dask distributes them, and repeats those of a worker that died. What a task leaves is in the store
before the task ends, so that neither a worker nor the scheduler nor this process takes anything
with it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from remodel_production.errors import PlannerError
from remodel_rehearsal.core.forecast import Change, with_entry
from remodel_rehearsal.core.variation import Uncertain
from remodel_rehearsal.edge.rehearsal_files import KeptTrial, RehearsalError, TrialStore, trial_key
from remodel_rehearsal.stack import Rehearsed, Setting, planned_wires, rehearse_wire
from remodel_run.rehearsal import Failure, Trial
from remodel_work.routes import PlacedWires

# The seed of the run that lays the boards, in which the cell is as its model.
NOMINAL_SEED = 0
# How often a task is repeated whose worker died.
_RETRIES = 3
# [s] In which a scheduler has to answer.
_CONNECT_S = 10


@dataclass(frozen=True)
class Job:
    """What all tasks of a rehearsal share.

    Attributes:
        setting: of the order.
        table: what is uncertain.
        store: URL of the store.
        mark: hash of what all trials follow from.
    """

    setting: Setting
    table: Mapping[str, Uncertain]
    store: str
    mark: str


_AS_PLANNED = Change("")


def done(
    job: Job,
    wire: str,
    seed: int,
    board: str,
    *,
    nominal: bool = False,
    change: Change = _AS_PLANNED,
) -> KeptTrial:
    """Return the trial of a wire from a board, made now or before.

    Args:
        job: of which it is a part.
        wire: its name.
        seed: of chance and variation.
        board: hash of the board before it.
        nominal: whether the cell is as its model.
        change: of how it is placed.
    """
    store = TrialStore(job.store)
    key = trial_key(job.mark, wire, seed, board, f"{change} {nominal}")
    kept = store.trial(key)
    if kept is not None:
        return kept
    with tempfile.TemporaryDirectory(prefix="rehearsal-") as folder:
        table = {} if nominal else job.table
        setting = _changed(job.setting, wire, change)
        try:
            found = rehearse_wire(setting, wire, seed, store.board(board), table, Path(folder))
            kept = _kept(store, found, Path(folder))
        except PlannerError:
            raise
        except Exception as error:  # noqa: BLE001 - all others go on, and this one is reported
            # Not kept: what was in its way may be gone the next time, such as a full disk.
            return KeptTrial(_broken_off(wire, seed, error), (), board, cpu_s=0.0, physics_s=0.0)
    store.put_trial(key, kept)
    return kept


def _broken_off(wire: str, seed: int, error: Exception) -> Trial:
    """Return the trial of a defect: of the stack, not of the wire."""
    text = f"the rehearsal itself failed, {type(error).__name__}: {error}; please report it"
    return Trial(wire, seed, placed=False, attempts=1, failures=(Failure("", "BROKEN_OFF", text),))


def _changed(setting: Setting, wire: str, change: Change) -> Setting:
    setting = replace(setting, force_n=change.force_n, longer_m=change.longer_m)
    if change.begin:
        entry = change.preference(wire, "tried")
        assert entry is not None, "preferences have first ends"
        setting = replace(setting, preferences=with_entry(setting.preferences, *entry))
    return setting


def _kept(store: TrialStore, found: Rehearsed, folder: Path) -> KeptTrial:
    trial = found.trial
    if trial.picture:
        trial = msgspec.structs.replace(trial, picture=store.put_picture(folder / trial.picture))
    return KeptTrial(
        trial,
        found.calls,
        store.put_board(found.board),
        cpu_s=found.cpu_s,
        physics_s=found.physics_s,
    )


def _laid(job: Job, wire: str, board: str, work: Callable[..., KeptTrial]) -> str:
    """Return the board with a wire, placed as the model has the cell; without it if it failed."""
    return work(job, wire, NOMINAL_SEED, board, nominal=True).board


def _as_it_is(job: Job) -> Job:
    """Return a job: the result of a task is computed again where its worker has died."""
    return job


@contextmanager
def connected(scheduler: str, workers: int) -> Iterator[Any]:
    """Yield a client of Dask.

    Args:
        scheduler: its address, such as tcp://10.0.0.5:8786; empty: processes on this machine.
        workers: how many of these.

    Raises:
        RehearsalError: if there is no scheduler at the address.
    """
    from distributed import Client, LocalCluster  # it takes longer to load than most commands

    if scheduler:
        try:
            client = Client(scheduler, timeout=_CONNECT_S)
        except (OSError, ValueError, TimeoutError) as error:
            raise RehearsalError(
                f"no scheduler of Dask at {scheduler}: {error}; start `dask scheduler`, and in the "
                "sourced workspace its workers, `dask worker --nthreads 1 ADDRESS`"
            ) from error
        with client:
            yield client
        return
    with (
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


class Rehearsing:
    """A rehearsal of one order that is being computed.

    Attributes:
        first: of each wire, in the order in which they are placed, the end that is inserted
            first: a or b; empty: the planner chooses.
    """

    def __init__(
        self,
        job: Job,
        seeds: Collection[int],
        client: Any,  # noqa: ANN401 - distributed has no types
        on_trial: Callable[[KeptTrial, int, int], None] = lambda kept, count, of: None,
        work: Callable[..., KeptTrial] = done,
    ) -> None:
        """Begin.

        Args:
            job: what is rehearsed.
            seeds: of the trials.
            client: of Dask.
            on_trial: called with each trial as it ends, how many have ended, and of how many.
            work: what each task does.

        Raises:
            PlannerError: if the order cannot be carried out.
        """
        self.first = planned_wires(job.setting)
        self._seeds, self._client, self._on_trial = seeds, client, on_trial
        self._work = work
        # Not scattered: what is scattered is lost with the worker that has it.
        self._job = client.submit(_as_it_is, job, pure=False)
        self._empty = TrialStore(job.store).put_board(PlacedWires())
        # Hash of the board before each wire, or what will be that.
        self._before: dict[str, Any] = {}

    def trials(self) -> list[KeptTrial]:
        """Return a trial of every wire with every seed; RehearsalError if the cluster is lost."""
        futures: list[Any] = []
        board: Any = self._empty
        last = next(reversed(self.first), "")
        for name in self.first:
            self._before[name] = board
            futures += [self._submit(self._work, name, seed, board) for seed in self._seeds]
            if name != last:
                board = self._submit(_laid, name, board, self._work, priority=10)
        trials = []
        for count, (_, kept) in enumerate(self._ended(futures), 1):
            self._on_trial(kept, count, len(futures))
            trials.append(kept)
        return trials

    def changed(
        self, changes: Mapping[str, Collection[Change]]
    ) -> dict[tuple[str, Change], list[KeptTrial]]:
        """Return, by wire and change, its trials with every seed; the changes are by wire."""
        futures = {
            self._submit(
                self._work,
                wire,
                seed,
                self._empty if change.is_first else self._before[wire],
                change=change,
            ): (wire, change)
            for wire, of_wire in changes.items()
            for change in of_wire
            for seed in self._seeds
        }
        found: dict[tuple[str, Change], list[KeptTrial]] = {}
        for future, kept in self._ended(list(futures)):
            found.setdefault(futures[future], []).append(kept)
        return found

    def _submit(self, work: Callable[..., object], *words: object, **options: object) -> Any:  # noqa: ANN401
        return self._client.submit(work, self._job, *words, retries=_RETRIES, pure=False, **options)

    def _ended(self, futures: list[Any]) -> Iterator[tuple[Any, KeptTrial]]:
        """Yield what was submitted as it ends, with its trial."""
        from distributed import KilledWorker, as_completed
        from distributed.client import FutureCancelledError

        for future in as_completed(futures):
            try:
                yield future, future.result()
            except KilledWorker as error:
                raise RehearsalError(
                    f"workers died again and again at one trial: {error}; their memory may be too "
                    "small. What was computed is kept: run the command again"
                ) from error
            except FutureCancelledError as error:
                raise RehearsalError(
                    "the scheduler of Dask has ended, or cannot be reached any more. What was "
                    "computed is kept: start it, and run the command again"
                ) from error
