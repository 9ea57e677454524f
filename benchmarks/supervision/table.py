"""The figures of the campaign, of each kind of fault and in sum."""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import median

from trial import Trial
from verdict import LEVELS, Verdict

Results = Sequence[tuple[Trial, Verdict]]

# In percent.
_LEAST_RECOVERED = 95.0

_HEAD = (
    f"{'':<22}{'runs':>6}{'can':>6}{'recovered':>11}{'right level':>13}{'extra cell':>12}"
    f"{'extra wall':>12}{'ended well':>12}{'hangs':>7}"
)


def print_table(results: Mapping[str, Results]) -> bool:
    """Print a table of each policy; return whether the first one meets the targets."""
    for policy, done in results.items():
        plain = [verdict for trial, verdict in done if not trial.kind]
        faulty = [(trial, verdict) for trial, verdict in done if trial.kind]
        print(f"\npolicy: {policy}; {len(plain)} runs without a fault")
        print(_HEAD)
        for kind in dict.fromkeys(trial.kind for trial, _ in faulty):
            print(_line(kind, [(t, v) for t, v in faulty if t.kind == kind], plain))
        print(_line("all", faulty, plain))
        for trial, verdict in done:
            if problem := _problem(trial, verdict):
                print(f"  run {verdict.run}: {trial.kind}, seed {trial.seed}, {problem}")
    first = [(trial, verdict) for trial, verdict in next(iter(results.values())) if trial.kind]
    recovered = _share([verdict.recovered for trial, verdict in first if trial.can_recover])
    ended_well = bool(first) and all(verdict.ended_well for _, verdict in first)
    return recovered >= _LEAST_RECOVERED and ended_well


def docs_rows(results: Mapping[str, Results]) -> Iterator[dict[str, str]]:
    """Yield the rows of the docs' table: a kind of fault each, then all; the first policy fully."""
    (policy, done), *others = results.items()
    plain = [verdict for trial, verdict in done if not trial.kind]
    faulty = [(trial, verdict) for trial, verdict in done if trial.kind]
    for kind in (*dict.fromkeys(trial.kind for trial, _ in faulty), ""):
        of_kind = [(t, v) for t, v in faulty if kind in ("", t.kind)]
        recovered = [v for t, v in of_kind if t.can_recover and v.recovered]
        row = {
            "kind": kind or "all",
            f"{policy}: recovered": _recovered(of_kind),
            "extra cell": _more([v.cell_s for v in recovered], [v.cell_s for v in plain]),
            "extra wall": _more([v.wall_s for v in recovered], [v.wall_s for v in plain]),
            "ended well": f"{sum(v.ended_well for _, v in of_kind)} of {len(of_kind)}",
        }
        for other, tried in others:
            found = [(t, v) for t, v in tried if t.kind and kind in ("", t.kind)]
            row[f"{other}: recovered"] = _recovered(found)
        yield row


def _recovered(done: Results) -> str:
    can = [verdict.recovered for trial, verdict in done if trial.can_recover]
    return f"{sum(can)} of {len(can)}" if can else "cannot"


def _line(kind: str, done: Results, plain: Sequence[Verdict]) -> str:
    can = [verdict for trial, verdict in done if trial.can_recover]
    recovered = [verdict for verdict in can if verdict.recovered]
    right = [
        verdict.first == LEVELS[trial.first_level]
        for trial, verdict in done
        if verdict.first and trial.first_level
    ]
    hangs = sum(verdict.hung for _, verdict in done)
    return (
        f"{kind:<22}{len(done):>6}{len(can):>6}{_percent([v.recovered for v in can]):>11}"
        f"{_percent(right):>13}"
        f"{_more([v.cell_s for v in recovered], [v.cell_s for v in plain]):>12}"
        f"{_more([v.wall_s for v in recovered], [v.wall_s for v in plain]):>12}"
        f"{_percent([v.ended_well for _, v in done]):>12}{hangs:>7}"
    )


def _problem(trial: Trial, verdict: Verdict) -> str:
    """Return what is not as it should be about a run; empty if all is."""
    found = [
        text
        for text, bad in (
            ("hung", verdict.hung),
            (f"not recovered, cure {trial.cure}", trial.can_recover and not verdict.recovered),
            ("what it says of the wires is not true", not verdict.true),
            ("the hand is not empty", not verdict.hand_empty),
            ("not explained", not verdict.explained),
            ("not replayed", not verdict.replayed),
            ("the fault has not shown", bool(trial.kind) and not verdict.struck),
        )
        if bad
    ]
    return "; ".join(found)


def _share(good: Sequence[bool]) -> float:
    return 100.0 * sum(good) / len(good) if good else 100.0


def _percent(good: Sequence[bool]) -> str:
    return f"{_share(good):.0f} %" if good else "-"


def _more(with_fault: Sequence[float], without: Sequence[float]) -> str:
    """Return by how many seconds the median run with a fault is longer."""
    if not with_fault or not without:
        return "-"
    return f"{median(with_fault) - median(without):+.1f} s"
