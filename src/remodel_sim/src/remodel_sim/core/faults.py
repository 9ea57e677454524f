"""Faults that are caused on purpose, and their limits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from remodel_work.errors import CellError
from remodel_work.geometry import Pose


class FaultError(CellError):
    """A fault that cannot be caused as it is asked for."""


class FilmError(CellError):
    """A run cannot be filmed."""


@dataclass(frozen=True)
class Value:
    """One of a fault's values and its limits."""

    name: str
    unit: str
    least: float
    most: float


@dataclass(frozen=True)
class FaultKind:
    """What a fault of this kind needs; `target` names what it is done to, empty: nothing."""

    target: str
    values: tuple[Value, ...] = ()


_SHIFT = tuple(Value(name, "m", -0.1, 0.1) for name in ("dx", "dy"))
KINDS: Mapping[str, FaultKind] = MappingProxyType(
    {
        "component_moved": FaultKind(
            "component", (*_SHIFT, Value("dyaw", "rad", -math.pi, math.pi))
        ),
        "socket_blocked": FaultKind("component/terminal"),
        "socket_cleared": FaultKind("component/terminal"),
        "friction_lowered": FaultKind("", (Value("share of the pads' friction", "", 0.01, 1.0),)),
        "grip_weakened": FaultKind("", (Value("share of the grip force", "", 0.05, 1.0),)),
        "camera_bumped": FaultKind(
            "camera",
            (
                *(Value(name, "m", -0.05, 0.05) for name in ("dx", "dy", "dz")),
                Value("turn about the view", "rad", -0.2, 0.2),
            ),
        ),
        "light_changed": FaultKind("", (Value("share of the light", "", 0.05, 3.0),)),
        "tip_bent": FaultKind("a or b", (Value("angle", "rad", -0.8, 0.8),)),
        "cable_in_the_way": FaultKind(
            "channel", (Value("y", "m", -0.5, 0.5), Value("turn", "rad", -0.5, 0.5))
        ),
        "server_frozen": FaultKind("", (Value("time", "s", 0.1, 600.0),)),
        "server_killed": FaultKind(""),
    }
)


def check_fault(kind: str, target: str, values: Sequence[float]) -> None:
    """Raise FaultError unless the kind exists and its target and values have the right form."""
    if kind not in KINDS:
        raise FaultError(f"no fault {kind!r}; there are: {', '.join(KINDS)}")
    needs = KINDS[kind]
    if not needs.target and target:
        raise FaultError(f"target is {target!r}; {kind} has none")
    if needs.target and not target:
        raise FaultError(f"target is empty; {kind} needs: {needs.target}")
    if needs.target == "component/terminal" and "/" not in target:
        raise FaultError(f"target is {target!r}; it must be 'component/terminal'")
    if " or " in needs.target and target not in needs.target.split(" or "):
        raise FaultError(f"target is {target!r}; allowed: {needs.target}")
    names = ", ".join(f"{v.name} [{v.unit}]" if v.unit else v.name for v in needs.values) or "none"
    if len(values) != len(needs.values):
        raise FaultError(f"values are {tuple(values)}; {kind} needs: {names}")
    for given, value in zip(values, needs.values, strict=True):
        if not value.least <= given <= value.most:
            raise FaultError(
                f"{kind}: {value.name} is {given} {value.unit}; allowed: {value.least:g} to "
                f"{value.most:g}"
            )


@dataclass(frozen=True)
class Stray:
    """A loose piece of cable across a channel; where its middle lies, panel frame [m, rad]."""

    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Disturbances:
    """The disturbances of the cell, until its panel is rebuilt.

    Attributes:
        friction: share of the pads' friction.
        grip: share of the grip force.
        light: share of the light.
        force_noise: standard deviation of a reading of a wrist's force, each axis [N].
        shifts: of bumped cameras by name: true optical frame in the one that the cell believes in.
        strays: pieces of cable that lie about.
    """

    friction: float = 1.0
    grip: float = 1.0
    light: float = 1.0
    force_noise: float = 0.0
    shifts: Mapping[str, Pose] = field(default_factory=lambda: MappingProxyType({}))
    strays: tuple[Stray, ...] = ()
