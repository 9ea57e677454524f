"""Compare seeds: `python3 -m random_charts --seed 0 --count 10000`.

Prints how many agree, and the chart of each that does not, shrunk. With `--trace` one seed is
printed in full: its charts, what the checker says, the behavior, and each run on both sides.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from scripted_states.script import Script

from random_charts.chart_xml import read_chart
from random_charts.engine_run import EngineRun, Synthesis
from random_charts.explore import explore
from random_charts.generate import Source, generate
from random_charts.judge import MOST_ROUNDS, Verdict, compare, judge, judge_seed
from random_charts.reference import Reference
from random_charts.shrink import shrink


def main(arguments: list[str]) -> int:
    """Return 0 if all seeds agree."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--runs", type=int, default=4, help="of each chart, all different")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--trace", action="store_true", help="print the first seed in full")
    given = parser.parse_args(arguments)
    if given.trace:
        trace(given.seed, given.runs)
        return 0
    seeds = range(given.seed, given.seed + given.count)
    wrong = []
    kinds: Counter[str] = Counter()
    with ProcessPoolExecutor(given.jobs) as pool:
        judged = pool.map(partial(verdict_of, runs=given.runs), seeds, chunksize=20)
        for seed, verdict in zip(seeds, judged, strict=True):
            kinds[verdict.kind] += 1
            kinds["of them not all runs explored"] += not verdict.is_explored
            if verdict.is_wrong:
                wrong.append(seed)
                show(seed, verdict, given.runs)
    print(f"{len(seeds)} charts from seed {given.seed}: {len(seeds) - len(wrong)} agree")  # noqa: T201
    for kind, number in kinds.most_common():
        print(f"{number:6} {kind}")  # noqa: T201
    print(f"seeds that do not agree: {wrong or 'none'}")  # noqa: T201
    return 1 if wrong else 0


def verdict_of(seed: int, runs: int) -> Verdict:
    """Return the verdict on a seed, whatever happens."""
    return guarded(lambda: judge_seed(seed, runs))


def guarded(work) -> Verdict:
    """Return a verdict, of an exception too."""
    try:
        return work()
    except Exception as error:  # noqa: BLE001 - whatever is wrong with synthesizer or engine
        return Verdict(type(error).__name__, [str(error)])


def show(seed: int, verdict: Verdict, runs: int) -> None:
    """Print what is wrong with a seed, shrunk."""
    source = generate(seed)
    small = shrink(
        source.files,
        source.path,
        lambda files: guarded(lambda: judge(files, source.path, runs)).kind == verdict.kind,
    )
    print(f"\nseed {seed}: {verdict.kind}")  # noqa: T201
    print_files(Source(small, source.path))
    print("\n".join(guarded(lambda: judge(small, source.path, runs)).details))  # noqa: T201
    sys.stdout.flush()


def print_files(source: Source) -> None:
    """Print charts."""
    for path, content in source.files.items():
        print(f"--- {path}\n{content.decode()}")  # noqa: T201


def trace(seed: int, runs: int) -> None:
    """Print all about a seed."""
    source = generate(seed)
    print_files(source)
    chart = read_chart(source.files, source.path)
    for fault in explore(chart):
        print(f"explored: {fault}")  # noqa: T201
    with tempfile.TemporaryDirectory() as folder:
        synthesis = Synthesis(source.files, source.path, Path(folder))
        for error in synthesis.errors:
            print(error)  # noqa: T201
        if synthesis.errors:
            return
        print(synthesis.text())  # noqa: T201
        for number in range(runs):
            trace_run(synthesis, chart, str(number))


def trace_run(synthesis: Synthesis, chart, seed: str) -> None:
    """Print a run on both sides."""
    given = {key: 1000 + index for index, key in enumerate(chart.inputs)}
    scripts = Script(seed), Script(seed)
    engine = EngineRun(synthesis.behavior(), scripts[0], given)
    engine.run(MOST_ROUNDS)
    reference = Reference(chart, scripts[1], given, engine.order)
    reference.run(MOST_ROUNDS)
    for title, run, script in zip(
        ("engine", "reference"), (engine, reference), scripts, strict=True
    ):
        print(f"run {seed}, {title}: {run.outcome} {run.outputs} {run.missing or ''}")  # noqa: T201
        for line in (*run.ended, *script.entered):
            print(f"    {line}")  # noqa: T201
    print("\n".join(compare(synthesis, chart, seed)))  # noqa: T201


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
