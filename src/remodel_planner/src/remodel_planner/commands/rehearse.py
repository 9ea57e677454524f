"""`remodel rehearse ORDER`: carry an order out in the simulated cell before the robot does."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import closing
from pathlib import Path

import msgspec
from tqdm import tqdm

from remodel_planner.commands.options.common import (
    add_database_option,
    count,
    refuses,
    seed,
    seeds,
)
from remodel_planner.commands.options.documents import add_json_option, print_json
from remodel_production.edge.database.production_database import ProductionDatabase, keep_rehearsal
from remodel_rehearsal.core.forecast import (
    adopted,
    adopted_names,
    changes_within,
    forecast,
    to_check,
    with_changes,
)
from remodel_rehearsal.edge.cluster import Job, Rehearsing, connected
from remodel_rehearsal.edge.rehearsal_files import (
    KeptTrial,
    TrialStore,
    hash_of_sources,
    mark_of,
    read_uncertainty,
)
from remodel_rehearsal.stack import Setting, carry_out, planned_wires, use_case_of
from remodel_run.rehearsal import Forecast, Rehearsal, WireForecast
from remodel_supervision.core.runs.events import Ending
from remodel_supervision.core.runs.state import RunState, Stage

# By default, seeds that no run of the simulated cell has by default.
_SEEDS = "100-109"
# Of a task that nothing more is done about.
_ENDED = frozenset({Stage.DONE, Stage.SET_ASIDE})


@refuses("rehearse")
def main(arguments: list[str] | None = None) -> int:
    """Rehearse an order, print what to expect, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel rehearse",
        description="Carry an order out in the simulated cell, without ROS and without the robot: "
        "every wire many times, each time in a cell that differs from its model as real ones do. "
        "Prints how often each wire succeeds, why not, and what would help, and keeps it with the "
        "order: plans take it into account, less than what the robot does.",
        epilog="Exit code: 0 rehearsed (with --seed: the order is complete), 1 refused or not "
        "complete, 2 wrong usage.",
    )
    parser.add_argument("order", metavar="ORDER", help="of the production database")
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--seeds", type=seeds, default=seeds(_SEEDS), help=f"such as 0-99 (default {_SEEDS})"
    )
    which.add_argument(
        "--seed",
        type=seed,
        metavar="N",
        help="carry the whole order out once, in the cell as its model is: as `remodel run` does "
        "in the simulated cell with this seed",
    )
    parser.add_argument(
        "--wires", type=count, default=0, metavar="N", help="only the first N (default: all)"
    )
    parser.add_argument("--cell", default="", help="name or file (default: that of the use case)")
    parser.add_argument("--use-case", default="", metavar="NAME", help="(default: by the design)")
    parser.add_argument(
        "--scheduler", default="", metavar="URL", help="of Dask (default: this machine)"
    )
    parser.add_argument(
        "--workers",
        type=count,
        default=len(os.sched_getaffinity(0)),
        metavar="N",
        help="processes on this machine (default: its cores, %(default)s)",
    )
    parser.add_argument(
        "--states",
        default=str(Path("out/rehearsal").absolute()),
        metavar="URL",
        help="folder or object store that all workers reach, for boards and trials (default: "
        "out/rehearsal); what it has is not computed again",
    )
    parser.add_argument(
        "--uncertainty", type=Path, metavar="FILE", help="your own numbers of what is uncertain"
    )
    parser.add_argument(
        "--no-changes", action="store_true", help="do not try what would help against failures"
    )
    parser.add_argument(
        "--adopt",
        action="store_true",
        help="enter what helped into the order's preferences, in place of what an earlier "
        "rehearsal has entered: plans and runs keep to it",
    )
    add_database_option(parser)
    add_json_option(parser)
    options = parser.parse_args(arguments)
    if options.adopt and (options.no_changes or options.seed is not None):
        parser.error("--adopt enters which changes help: leave out --no-changes and --seed")
    with closing(ProductionDatabase(options.database)) as database:
        setting = Setting(
            database.order(options.order),
            options.cell,
            options.use_case,
            options.wires,
            preferences=database.preferences(options.order),
        )
        if options.seed is not None:
            return _carry_out(setting, options.seed)
        found = _rehearse(setting, options, database)
    if options.json:
        print_json(msgspec.to_builtins(found))
    else:
        print("\n".join(lines(found)))
        for wire in found.failing[:3]:
            print(f"picture of {wire.wire}: {_shown(wire, options.states)}")
        if found.adopted is not None:
            print(
                "adopted, in the order's preferences:", *(found.adopted or ("nothing",)), sep="\n  "
            )
    return 0


def _carry_out(setting: Setting, seed_of_cell: int) -> int:
    """Carry an order out once, print what became of it, and return the exit code."""
    done: set[str] = set()
    with _bar(len(planned_wires(setting))) as bar:

        def watch(state: RunState) -> None:
            ended = {name for name, task in state.tasks.items() if task.stage in _ENDED}
            for name in sorted(ended - done):
                print(f"{name}: {state.tasks[name].stage.value.replace('_', ' ')}", flush=True)
                bar.update()
            done.update(ended)

        outcome = carry_out(setting, seed=seed_of_cell, watch=watch)
    ended = outcome.state.ended
    assert ended is not None, "supervise returns at the end"
    print(f"{ended.ending.value}: {ended.because}")
    print(f"{outcome.cell_s:.1f} s in the cell; board {outcome.board_hash}")
    return 0 if ended.ending is Ending.COMPLETE else 1


def _rehearse(
    setting: Setting, options: argparse.Namespace, database: ProductionDatabase
) -> Forecast:
    table = read_uncertainty(options.uncertainty)
    mark = mark_of(setting, table, hash_of_sources())
    job = Job(setting, table, options.states, mark)
    TrialStore(options.states)  # refuses a place that cannot be written to, before anything begins
    with connected(options.scheduler, options.workers) as client, _bar(None) as bar:

        def on_trial(kept: KeptTrial, count: int, of: int) -> None:
            bar.total, bar.n = of, count
            trial = kept.trial
            bar.set_description_str(
                f"{trial.wire}, seed {trial.seed}: "
                + (trial.failures[0].code if trial.failures else "placed")
            )
            if options.json:
                print(f"stage {count}/{of}: {trial.wire}", file=sys.stderr, flush=True)

        rehearsing = Rehearsing(job, options.seeds, client, on_trial)
        kept = rehearsing.trials()
        found = forecast(rehearsing.first, (each.trial for each in kept))
        failing = () if options.no_changes else to_check(found)
        explored: list[KeptTrial] = []
        pushes = use_case_of(setting).learned.get("InsertCable", {})
        changes = {wire: changes_within(pushes, rehearsing.first[wire]) for wire in failing}
        if failing:
            bar.set_description_str(f"trying what would help {', '.join(failing)}")
            tried = rehearsing.changed(changes)
            found = with_changes(
                found,
                {
                    (w, change.text): [each.trial for each in of]
                    for (w, change), of in tried.items()
                },
            )
            # Other settings of pushes are explored here in place of on the robot.
            explored = [each for (_, change), of in tried.items() if change.force_n for each in of]
    if options.adopt:
        # As they are now: a rehearsal may take hours.
        document = adopted(found, changes, database.preferences(setting.order.name))
        database.set_preferences(setting.order.name, document)
        found = msgspec.structs.replace(found, adopted=adopted_names(document))
    keep_rehearsal(
        database,
        setting.order.name,
        Rehearsal(
            options.cell,
            tuple(rehearsing.first),
            tuple(each.trial for each in kept),
            tuple(call for each in (*kept, *explored) for call in each.calls),
            forecast=found,
        ),
    )
    return found


def lines(found: Forecast) -> list[str]:
    """Return a forecast as a person reads it: a line for each wire, and what to check."""
    rows = [f"{'wire':<8}{'trials':>7}  {'at the first attempt':<24}{'placed':<24}most often"]
    rows += [
        f"{wire.wire:<8}{wire.trials:>7}  {wire.at_once!s:<24}{wire.placed!s:<24}"
        + (f"{wire.failure.ability} {wire.failure.code}".strip() if wire.failure else "")
        for wire in found.wires
    ]
    mean, low, high = found.cell_s
    rows += [
        "",
        f"the whole order: {found.all_at_once:.0%} without a failure; {_minutes(mean)} in the cell "
        f"({_minutes(low)} to {_minutes(high)})",
    ]
    for wire in found.failing[:3]:
        assert wire.failure is not None, "it failed"
        rows.append(f"check {wire.wire}: {wire.failure.text}")
        rows += [f"  {each.text}: {each.at_once}" for each in wire.changes]
        if wire.changes and wire.changes[0].at_once.mean <= wire.at_once.mean:
            rows.append("  none of this helps: place it by hand, or check its picture")
    return rows


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f} min"


def _shown(wire: WireForecast, states: str) -> str:
    return f"{states}/pictures/{wire.picture}" if wire.picture else "none"


def _bar(count: int | None) -> tqdm:
    return tqdm(
        total=count,
        file=sys.stderr,
        leave=False,
        disable=None,
        bar_format="{percentage:3.0f} % |{bar:16}| {elapsed} of {remaining}  {desc}",
    )
