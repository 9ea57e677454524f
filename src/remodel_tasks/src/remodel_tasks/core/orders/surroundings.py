"""The cell around a board: where the magazine and the arms are. Lengths in mm, board's frame."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from remodel_production.core.board.formboard import Point as PointM
from remodel_tasks.core.problem.problem import PlannedArm, Point
from remodel_tasks.core.use_case.designs import Designs


class Surroundings:
    """What a use case states of its cell, around the points that the arms must reach."""

    def __init__(self, points: Iterable[Point], designs: Designs, arms: int) -> None:
        """Take the points, and how many arms there are at most: 1 or 2."""
        points = list(points)
        self.left, self.right = min(x for x, _ in points), max(x for x, _ in points)
        low = min(y for _, y in points)
        self.slot_y = low - round(1e3 * designs.magazine_below_m)
        self._home_y = low - round(1e3 * designs.home_below_m)
        self.arms = self._placed(designs, min(arms, len(designs.arms)))

    def _placed(self, designs: Designs, count: int) -> tuple[PlannedArm, ...]:
        beside, beyond = (
            round(1e3 * length) for length in (designs.station_beside_m, designs.reach_beyond_m)
        )
        left, right = self.left, self.right
        sides = [(left, left - beside, (left - beyond, right + beyond))]
        if count == 2:
            reach = round((right - left) * designs.reach_of_two)
            sides = [
                (left, left - beside, (left - beyond, left + reach)),
                (right, right + beside, (right - reach, right + beyond)),
            ]
        return tuple(
            PlannedArm(
                name,
                (station, self.slot_y),
                reach,
                (home, self._home_y),
                tool=designs.tool,
                holding=None,
            )
            for name, (home, station, reach) in zip(designs.arms, sides, strict=False)
        )

    def able(self, *xs: int) -> tuple[PlannedArm, ...]:
        """Return the arms that reach all of some x."""
        return tuple(
            arm for arm in self.arms if arm.reach_mm[0] <= min(xs) and max(xs) <= arm.reach_mm[1]
        )

    def nearer(self, *xs: int) -> PlannedArm | None:
        """Return the arm on whose side the middle of some x is; None where there is one arm."""
        if len(self.arms) == 1:
            return None
        return self.arms[2 * sum(xs) >= len(xs) * (self.left + self.right)]

    def meeting(self, path: tuple[Point, ...]) -> Point:
        """Return where a route first crosses the middle of the board, or comes nearest to it."""
        middle = (self.left + self.right) / 2
        crossing = (
            (p, q) for p, q in pairwise(path) if min(p[0], q[0]) <= middle <= max(p[0], q[0])
        )
        p, q = next(crossing, (None, None))
        if p is None or q is None:
            return min(path, key=lambda point: abs(point[0] - middle))
        share = 0.0 if p[0] == q[0] else (middle - p[0]) / (q[0] - p[0])
        return round(middle), round(p[1] + share * (q[1] - p[1]))


def in_mm(point: PointM) -> Point:
    """Return a point of a board [m] in mm."""
    return round(1e3 * point[0]), round(1e3 * point[1])
