"""What rehearsed runs of wires say about the next real one."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from statistics import fmean

from remodel_run.rehearsal import Forecast, Share, Trial, WireForecast
from remodel_supervision.core.learning.belief import Belief


def share(successes: int, trials: int) -> Share:
    """Return the probability of which so many of so many trials succeeded.

    Jeffreys' prior (Proc. R. Soc. A 186, 1946), half a success and half a failure, so that no
    number of trials makes a probability certain.
    """
    belief = Belief(successes + 0.5, trials - successes + 0.5)
    return Share(belief.mean, *belief.interval())


# How many orders are drawn from what was rehearsed, for the spread of their time.
_DRAWS = 2000


def forecast(names: Sequence[str], trials: Iterable[Trial]) -> Forecast:
    """Return what trials say of the wires of an order.

    Args:
        names: of the wires, in the order in which they are placed; those without a trial are left
            out.
        trials: of these wires.
    """
    by_wire: dict[str, list[Trial]] = {}
    for trial in trials:
        by_wire.setdefault(trial.wire, []).append(trial)
    known = [name for name in names if name in by_wire]
    wires = tuple(_of_wire(name, by_wire[name]) for name in known)
    return Forecast(
        wires,
        math.prod(wire.at_once.mean for wire in wires),
        _whole_time([[trial.cell_s for trial in by_wire[name]] for name in known]),
    )


def _of_wire(name: str, trials: Sequence[Trial]) -> WireForecast:
    ordered = sorted(trials, key=lambda trial: trial.seed)
    failed = [trial for trial in ordered if trial.failures]
    kinds = Counter((trial.failures[0].ability, trial.failures[0].code) for trial in failed)
    failure, picture = None, ""
    if failed:
        (kind, _), *_ = kinds.most_common(1)
        of_kind = [t for t in failed if (t.failures[0].ability, t.failures[0].code) == kind]
        failure = of_kind[0].failures[0]
        picture = next((trial.picture for trial in of_kind if trial.picture), "")
    return WireForecast(
        name,
        len(ordered),
        share(sum(trial.at_once for trial in ordered), len(ordered)),
        share(sum(trial.placed for trial in ordered), len(ordered)),
        failure,
        fmean(trial.cell_s for trial in ordered),
        picture,
    )


def _whole_time(times: Sequence[Sequence[float]]) -> tuple[float, float, float]:
    """Return mean, 5 % and 95 % of the sum of one time of each wire [s]."""
    if not times:
        return 0.0, 0.0, 0.0
    random = Random(1)
    sums = sorted(sum(random.choice(each) for each in times) for _ in range(_DRAWS))
    return fmean(sums), sums[_DRAWS // 20], sums[-_DRAWS // 20]


def brier_score(forecasts: Mapping[str, float], outcomes: Iterable[tuple[str, bool]]) -> float:
    """Return the mean squared difference between probabilities and what happened.

    Brier, Mon. Weather Rev. 78 (1950), for one of two classes: 0 is certain and right, 0.25 a coin.

    Args:
        forecasts: probability of success by wire.
        outcomes: wires, and whether they succeeded; at least one.
    """
    return fmean((forecasts[wire] - success) ** 2 for wire, success in outcomes)
