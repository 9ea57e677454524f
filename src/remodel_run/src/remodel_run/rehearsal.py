"""What rehearsals of an order in the simulated cell say of its next real run."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec


class Failure(msgspec.Struct, frozen=True):
    """What went wrong in an attempt.

    Attributes:
        ability: that failed; empty: none, the cell or its feeder refused.
        code: name of its error; NOT_PLACED if no ability failed.
        text: what it said.
    """

    ability: str
    code: str
    text: str


class Trial(msgspec.Struct, frozen=True):
    """One wire, rehearsed with one seed.

    Attributes:
        wire: its name.
        seed: of chance and variation.
        placed: whether it had its place at the end, by the ground truth.
        attempts: at the task.
        failures: in their order, those that were mended too.
        cell_s: time in the cell [s].
        picture: file name of the picture of its failure; empty: none.
    """

    wire: str
    seed: int
    placed: bool
    attempts: int
    failures: tuple[Failure, ...] = ()
    cell_s: float = 0.0
    picture: str = ""

    @property
    def at_once(self) -> bool:
        """Whether the first attempt succeeded, and no ability failed in it."""
        return self.placed and self.attempts == 1 and not self.failures


class RehearsedCall(msgspec.Struct, frozen=True, array_like=True):
    """A call of an ability in a rehearsal, as learning takes it.

    Attributes:
        ability: its name.
        features: of the task that it was part of.
        error_code: 0 for none.
        elapsed_s: time in the cell [s].
        parameters: numbers of its goal, by name.
    """

    ability: str
    features: Mapping[str, str | float | bool]
    error_code: int
    elapsed_s: float
    parameters: Mapping[str, float]


class Share(msgspec.Struct, frozen=True):
    """A probability, by what was counted.

    Attributes:
        mean: expected.
        low: of the 90 % interval.
        high: of the 90 % interval.
    """

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        """Return it as a person reads it."""
        return f"{self.mean:.0%} ({self.low:.0%} to {self.high:.0%})"


class TriedChange(msgspec.Struct, frozen=True):
    """A change that was tried against a failure, with the seeds of the forecast.

    Attributes:
        text: what is changed, such as "8 cm longer".
        at_once: the probability that the first attempt succeeds then.
    """

    text: str
    at_once: Share


class WireForecast(msgspec.Struct, frozen=True):
    """What is expected of one wire.

    Attributes:
        wire: its name.
        trials: how often it was rehearsed.
        at_once: the probability that the first attempt succeeds.
        placed: the probability that it has its place in the end.
        failure: the most frequent of its first failures; None: it never failed.
        cell_s: mean time in the cell [s].
        picture: file name of a picture of that failure; empty: none.
        changes: that were tried, the best first.
    """

    wire: str
    trials: int
    at_once: Share
    placed: Share
    failure: Failure | None
    cell_s: float
    picture: str = ""
    changes: tuple[TriedChange, ...] = ()


class Forecast(msgspec.Struct, frozen=True):
    """What is expected of an order.

    Attributes:
        wires: in the order in which they are placed.
        all_at_once: probability that every wire is placed at the first attempt, if they fail
            independently of each other.
        cell_s: time of the whole order [s]: mean, and 5 % and 95 % of sums of what was rehearsed.
        adopted: names of the entries of the order's preferences that come from rehearsals; None:
            what helps was not adopted.
    """

    wires: tuple[WireForecast, ...]
    all_at_once: float
    cell_s: tuple[float, float, float]
    adopted: tuple[str, ...] | None = None

    @property
    def failing(self) -> tuple[WireForecast, ...]:
        """The wires to check: those that failed, the most frequently first."""
        failed = (wire for wire in self.wires if wire.failure is not None)
        return tuple(sorted(failed, key=lambda wire: (wire.at_once.mean, wire.placed.mean)))


class Rehearsal(msgspec.Struct, frozen=True):
    """A rehearsal of an order, as the production database keeps it.

    Attributes:
        cell: name or file of the cell.
        wires: in the order in which they are placed.
        trials: of these wires.
        calls: of abilities in these trials.
        forecast: what they say.
    """

    cell: str
    wires: tuple[str, ...]
    trials: tuple[Trial, ...]
    calls: tuple[RehearsedCall, ...]
    forecast: Forecast
