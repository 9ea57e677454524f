"""`remodel replay RUN`: play a recorded run back, and compare."""

from __future__ import annotations

import argparse

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_run.whole_task import counted
from remodel_supervision.core.runs.event_table import attempts_of
from remodel_supervision.core.runs.events import OperationEnded, kind_of
from remodel_supervision.core.runs.replay import path_difference, replayed
from remodel_supervision.core.runs.step import description_of, next_step
from remodel_supervision.edge.known_behaviors import nested_charts
from remodel_supervision.edge.run_log import KeptEvent, kept_run
from remodel_tasks.edge.fault_file import read_error_names


@refuses("replay")
def main(arguments: list[str] | None = None) -> int:
    """Print each event with what came next, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel replay",
        description="Play a recorded run back: every event with the states that were entered and "
        "what came next, and whether all of it follows from what was before.",
        epilog="Exit code: 0 played back identically, 1 something differs, or no such run or "
        "database, 2 wrong usage.",
    )
    parser.add_argument("run", type=int, metavar="RUN", help="number of the run")
    parser.add_argument("--quiet", action="store_true", help="print the differences only")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    kept = kept_run(options.database, options.run)
    differences = _play(kept, quiet=options.quiet)
    for difference in differences:
        print(f"DIFFERS: {difference}")
    behaviors = len(attempts_of(each.event for each in kept))
    events, different = counted(len(kept), "event"), counted(len(differences), "difference")
    print(f"{events}, {counted(behaviors, 'behavior')}, {different}")
    return 1 if differences else 0


def _play(kept: tuple[KeptEvent, ...], *, quiet: bool) -> list[str]:
    """Print the run, and return what differs."""
    differences = []
    nested, error_names = nested_charts(), read_error_names()
    attempts = list(attempts_of(each.event for each in kept))
    for number, (each, frame) in enumerate(
        zip(kept, replayed([each.event for each in kept]), strict=True)
    ):
        since_s = (each.at - kept[0].at).total_seconds()
        if frame.differs:
            differences.append(f"event {number}, {kind_of(each.event)}: {frame.differs}")
        if quiet:
            continue
        if isinstance(each.event, OperationEnded):
            operation = each.event.operation
            print(f"{since_s:9.3f}      {operation.state_path} > {operation.outcome}")
            continue
        step = next_step(frame.after)
        then = f"  then {description_of(step)}" if step is not None else ""
        print(f"{since_s:9.3f}  {kind_of(each.event)}{then}")
    for attempt in attempts:
        label = f"{attempt.execution.behavior}, attempt {attempt.execution.attempt}"
        chart = parse_chart(attempt.chart, label)
        if difference := path_difference(attempt, chart, nested, error_names):
            differences.append(f"{label}: {difference}")
    return differences
