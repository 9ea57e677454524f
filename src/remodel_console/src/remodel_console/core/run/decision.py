"""States in which an operator chooses the outcome, as the chart of a behavior describes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from flexbe_synthesizer.core.chart.model import Chart, Container, State
from remodel_console.core.editor.drawing import drawn_path, drawn_paths

_CLASS = "OperatorDecisionState"


@dataclass(frozen=True)
class Decision:
    """What a state lets an operator choose.

    Attributes:
        outcomes: to choose from, in the order of the state.
        hint: what the state says to the operator; empty without one.
        suggestion: the outcome that is taken if autonomy allows; empty if the state always waits.
    """

    outcomes: tuple[str, ...]
    hint: str = ""
    suggestion: str = ""


@dataclass(frozen=True)
class Decisions:
    """The decisions of the behavior whose source has a checksum, by their paths in its chart."""

    behavior_id: int = 0
    by_path: Mapping[str, Decision] = field(default_factory=dict)
    paths: frozenset[str] = frozenset()

    def at(self, engine_path: str) -> Decision | None:
        """Return the decision of a state, as the engine names it; None if it is of another kind."""
        return self.by_path.get(drawn_path(engine_path, self.paths)) if self.by_path else None


def decisions_of(chart: Chart, behavior_id: int) -> Decisions:
    """Return the decisions in a chart, in its containers too."""
    return Decisions(behavior_id, dict(_found(chart, "")), drawn_paths(chart))


def _found(chart: Chart, prefix: str) -> Iterator[tuple[str, Decision]]:
    for node in chart.nodes:
        path = f"{prefix}{node.id}"
        if isinstance(node, Container):
            yield from _found(node.body, f"{path}/")
        elif isinstance(node, State) and node.type.rpartition(".")[2] == _CLASS:
            given = {param.name: param.value for param in node.params}
            outcomes = given.get("outcomes")
            if isinstance(outcomes, tuple):
                yield (
                    path,
                    Decision(
                        tuple(map(str, outcomes)),
                        str(given.get("hint") or ""),
                        str(given.get("suggestion") or ""),
                    ),
                )
