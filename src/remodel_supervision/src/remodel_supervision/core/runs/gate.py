"""The one gate through which everything passes that makes a cell move.

A state or supervisor asks before it begins an operation; a pause holds it, everything else that
closes the gate (stop, skip, protective stop, shutdown, a lost lease) halts it, and what runs is
cancelled besides. From the permission to the end of the operation the gate counts it as moving. A
command that closes the gate is answered when nothing moves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

# The feeder asks under this name. No command can stop it: it moves until it has answered.
FEEDER = "feeder"


class Permit(Enum):
    """The answer to a request to begin.

    HELD: not now, ask again. REFUSED: not at all.
    """

    GRANTED = "granted"
    HELD = "held"
    REFUSED = "refused"


@dataclass
class Gate:
    """What closes the gate, and what has passed it.

    Attributes:
        halt: why what runs is to be stopped; empty: it is not.
        hold: why nothing new may begin; empty: it may.
        moving: what has begun and not ended, by the name under which it asked.
    """

    halt: str = ""
    hold: str = ""
    moving: dict[str, str] = field(default_factory=dict)

    @property
    def why(self) -> str:
        """Why the gate is closed; empty if it is open."""
        return self.halt or self.hold

    @property
    def is_still(self) -> bool:
        """Whether nothing moves that has passed the gate."""
        return not self.moving

    def ask(self, name: str, what: str) -> Permit:
        """Return whether an operation may begin; once it is granted it counts as moving.

        Args:
            name: under which its end will be reported, such as the path of a state.
            what: for a person.
        """
        if self.halt:
            return Permit.REFUSED
        if self.hold:
            return Permit.HELD
        self.moving[name] = what
        return Permit.GRANTED

    def end(self, name: str) -> None:
        """Note that an operation has ended; one that never passed changes nothing."""
        self.moving.pop(name, None)

    def clear(self) -> None:
        """Note that no ability moves any more; a feeder that is at work is not one."""
        for name in self.moving.keys() - {FEEDER}:
            self.end(name)
