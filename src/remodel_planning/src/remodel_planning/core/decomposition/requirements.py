"""What requirements forbid while tasks are decomposed, before there is a plan to violate them."""

from __future__ import annotations

from remodel_planning.core.decomposition.decomposed import Limits
from remodel_planning.core.problem.choices import choose
from remodel_planning.core.problem.preferences import document_fields, requirements
from remodel_planning.core.problem.problem import Problem


def limits_of(problem: Problem, document: object, situations: frozenset[str]) -> Limits:
    """Return the limits that a preferences document sets, in the present situations.

    Args:
        problem: of the tasks decomposed without limits, by which wires are chosen.
        document: parsed.
        situations: in which requirements with a `while` count.

    Raises:
        InstanceError: naming the first entry that is malformed or speaks of what is not there.
    """
    force_n: dict[str, tuple[float, str]] = {}
    segments: dict[str, str] = {}
    for item in requirements(document_fields(document)):
        if item.has("while") and item.text("while") not in situations:
            continue
        if item.has("force_n"):
            limit = (float(item.number("force_n", least=1)), item.text("name"))
            for wire in choose(problem, item, "insert"):
                force_n[wire.name] = min(limit, force_n.get(wire.name, limit))
        elif item.has("avoid_segment"):
            segments[item.text("avoid_segment")] = item.text("name")
    return Limits(force_n, segments)
