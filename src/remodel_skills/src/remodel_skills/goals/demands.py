"""What an order demands of the cell's robots, against what they can do, before anything moves."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from remodel_skills.goals.ability_goals import FORCE_LIMITS_N


def find_demand_problems(
    robots: Collection[str], forces_n: Mapping[str, float], there: Collection[str]
) -> Iterator[str]:
    """Yield why goals of an order would be refused, one sentence each.

    Args:
        robots: that its goals name.
        forces_n: the greatest force limit [N] of its goals, by the ability.
        there: names of the cell's robots.
    """
    for robot in robots:
        if robot not in there:
            yield f"the order's goals name robot {robot!r}; the cell has {', '.join(there)}"
    for ability, force_n in forces_n.items():
        most_n = FORCE_LIMITS_N.get(ability, float("inf"))
        if force_n > most_n:
            yield (
                f"the use case has {ability} push with up to {force_n:g} N; this cell's grip "
                f"holds at most {most_n:g} N"
            )
