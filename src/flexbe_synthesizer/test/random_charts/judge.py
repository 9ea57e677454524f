"""Do the engine and the reference agree about a chart?"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from scripted_states.script import Script

from flexbe_synthesizer.core.chart.problem import ProblemKind
from random_charts.chart_xml import CHART, Scope, read_chart
from random_charts.engine_run import EngineRun, Synthesis
from random_charts.explore import Fault, TooManyRunsError, explore
from random_charts.generate import generate
from random_charts.reference import Reference

MOST_ROUNDS = 150
_DATA_CODES = {ProblemKind.READ_BEFORE_WRITE, ProblemKind.OVERWRITTEN_VALUE}


@dataclass
class Verdict:
    """What became of a chart.

    Attributes:
        kind: "agree", "refused" (rightly), "refused without need", or what is wrong.
        details: what is wrong, or why it was refused.
        is_explored: whether all runs could be followed.
    """

    kind: str
    details: list[str] = field(default_factory=list)
    is_explored: bool = True

    @property
    def is_wrong(self) -> bool:
        """Whether synthesizer, engine and reference do not agree."""
        return self.kind not in ("agree", "refused", "refused without need")


def judge_seed(seed: int, runs: int) -> Verdict:
    """Return the verdict on the chart of a seed."""
    source = generate(seed)
    return judge(source.files, source.path, runs)


def judge(files: Mapping[str, bytes], path: str, runs: int) -> Verdict:
    """Return the verdict on a chart.

    Args:
        files: the chart's and those that it names.
        path: the chart's.
        runs: how many different runs to compare.
    """
    chart = read_chart(files, path)
    try:
        faults: tuple[Fault, ...] | None = explore(chart)
    except TooManyRunsError:
        faults = None
    folder = Path(tempfile.mkdtemp(prefix="random_charts_"))
    try:
        verdict = _judge(Synthesis(files, path, folder), chart, faults, runs)
    finally:
        shutil.rmtree(folder)
    verdict.is_explored = faults is not None
    return verdict


def _judge(
    synthesis: Synthesis, chart: Scope, faults: tuple[Fault, ...] | None, runs: int
) -> Verdict:
    errors = [str(error) for error in synthesis.errors]
    codes = {error.code for error in synthesis.errors}
    if has_conflict(chart) and ProblemKind.CONFLICTING_OUTPUT in codes:
        return Verdict("refused", errors)
    if codes - _DATA_CODES:
        return Verdict("valid chart refused", errors)
    if synthesis.errors:
        return Verdict("refused" if faults or faults is None else "refused without need", errors)
    if faults:
        return Verdict("accepted with a hole in its data", [*map(str, faults)])
    for number in range(runs):
        differences = compare(synthesis, chart, str(number))
        if differences:
            return Verdict(f"other {differences[0]}", [f"run {number}:", *differences[1:]])
    return Verdict("agree")


def has_conflict(chart: Scope) -> bool:
    """Return whether an output would have to be in two places."""
    for node in chart.nodes.values():
        if node.scope is not None and has_conflict(node.scope):
            return True
    found = [place for output in chart.outputs for place in chart.feeders(output)]
    is_double = len(set(found)) < len(found)
    return is_double or any(
        chart.place(node.id, output) not in ((node.id, output), (CHART, output))
        for node in chart.nodes.values()
        for output in set(node.outputs) & set(chart.outputs)
    )


def compare(synthesis: Synthesis, chart: Scope, seed: str) -> list[str]:
    """Run a chart twice; return what differs: in which respect, then on both sides."""
    engine_script, script = Script(seed), Script(seed)
    needed = [key for key, default in chart.inputs.items() if default is ... or seed == "1"]
    given = {key: 1000 + index for index, key in enumerate(needed)}
    engine = EngineRun(synthesis.behavior(), engine_script, given)
    engine.run(MOST_ROUNDS)
    reference = Reference(chart, script, given, engine.order)
    reference.run(MOST_ROUNDS)
    passed = {key: given.get(key, default) for key, default in chart.inputs.items()}
    outputs = {key: reference.outputs.get(key, passed.get(key)) for key in chart.outputs}
    pairs = {
        "death": (engine.missing, reference.missing),
        "path": (_steps(engine.ended), _steps(reference.ended)),
        "values read": (engine_script.entered, script.entered),
        "outcome": (engine.outcome, reference.outcome),
        "outputs": (dict(engine.outputs), outputs),
    }
    for respect, (found, expected) in pairs.items():
        if found != expected:
            return [respect, *_difference(found, expected)]
    if engine.missing:
        return ["run: it died", engine.missing]
    return []


def _steps(ended: list[tuple[int, str, str]]) -> list[tuple[int, str, str]]:
    """Return the steps without the names of an added chooser's outcomes, which are its own."""
    return [(n, path, "" if path.endswith("_error") else event) for n, path, event in ended]


def _difference(found: object, expected: object) -> list[str]:
    if not isinstance(found, list) or not isinstance(expected, list):
        return [f"engine:    {found}", f"reference: {expected}"]
    same = 0
    while found[: same + 1] == expected[: same + 1]:
        same += 1
    shown = slice(max(0, same - 4), same + 4)
    return [
        f"the same up to step {same}",
        *(f"engine:    {step}" for step in found[shown]),
        *(f"reference: {step}" for step in expected[shown]),
    ]
