"""Which unfinished wire must be done before which."""

from __future__ import annotations

from collections.abc import Iterator

from remodel_tasks.core.problem.problem import End, PlannedWire, Problem, Stage


def wire_order(problem: Problem) -> Iterator[tuple[str, str]]:
    """Yield the pairs of unfinished wires of which the first must be done before the second.

    Constraints speak of routes and ends. With a list of whole wires that satisfies these pairs, the
    arms satisfy the constraints, whatever they do at the same time.
    """
    for under in problem.unders:
        before, after = problem.wire[under.before], problem.wire[under.after]
        if before.stage < Stage.ROUTED and after.stage < Stage.ROUTED:
            yield under.before, under.after
    for pin in problem.pins:
        if (
            pin.before != pin.after
            and not is_inserted(problem.wire[pin.before], pin.before_end)
            and not is_inserted(problem.wire[pin.after], pin.after_end)
        ):
            yield pin.before, pin.after


def is_inserted(wire: PlannedWire, end: End) -> bool:
    """Return whether an end is in its terminal when planning begins."""
    if wire.stage >= Stage.SECOND_IN:
        return True
    return wire.stage >= Stage.FIRST_IN and wire.first is end
