"""Faults by their physical causes in the simulated cell, drawn from a seed."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from trial import Trial

from remodel_production.core.production import TerminalRef

# Kind of remodel_msgs/InjectFault -> whether it can be put right without a person. A blocked
# opening stays blocked. The shares and shifts are such as a cell meets: a mount that gives way by
# millimetres, pads that are worn or oily, a lamp that is out.
KINDS = {
    "component_moved": True,
    "socket_blocked": False,
    "friction_lowered": True,
    "grip_weakened": True,
    "camera_bumped": True,
    "light_changed": True,
    "tip_bent": True,
}


def drawn(kind: str, seed: int, ends: Sequence[TerminalRef]) -> Trial:
    """Return a trial of a physical fault.

    Args:
        kind: of KINDS.
        seed: of the draw.
        ends: terminals into which wires are inserted.
    """
    random = Random(f"{kind} {seed}")
    end = random.choice(ends)
    sign = random.choice([-1.0, 1.0])
    target, values = {
        "component_moved": (
            end.component,
            [random.uniform(-0.006, 0.006), random.uniform(-0.006, 0.006), 0.0],
        ),
        "socket_blocked": (f"{end.component}/{end.terminal}", []),
        "friction_lowered": ("", [random.uniform(0.3, 0.7)]),
        "grip_weakened": ("", [random.uniform(0.3, 0.7)]),
        "camera_bumped": (
            "overhead",
            [random.uniform(-0.003, 0.003), random.uniform(-0.003, 0.003), 0.0, 0.0],
        ),
        "light_changed": ("", [random.uniform(0.4, 1.6)]),
        "tip_bent": (random.choice("ab"), [sign * random.uniform(0.1, 0.4)]),
    }[kind]
    fault = {"kind": kind, "target": target, "values": values}
    cure = "any" if KINDS[kind] else ""
    return Trial(kind, seed, cure=cure, faults=(fault,))
