"""What happened in a run: executions of wires' behaviors, made of operations of abilities."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_states.core.codes import Code

# Of a hand that has nothing to lay down.
NOTHING_TO_LAY_DOWN = frozenset({Code.NOTHING_HELD, Code.WIRE_NOT_FED})

# The abilities that end with an empty hand.
EMPTYING = ("PlaceCable", "DiscardCable")


@dataclass(frozen=True)
class Operation:
    """One execution of an ability by a state.

    Attributes:
        state_path: of the state in the behavior, such as "/Connect a/InsertCable".
        ability: such as "InsertCable".
        outcome: of the state; empty when it was left without one.
        error_code: remodel_msgs/ErrorCode, 0 for none.
        text: the result's message, or the error message.
        ended_s: [s] ROS time.
        elapsed_s: [s] ROS time.
        goal_id: of its goal, unique in one behavior's execution.
        parameters: of its goal, name -> value as text.
        measurements: of its result, name -> value as text.
    """

    state_path: str
    ability: str
    outcome: str
    error_code: int
    text: str
    ended_s: float
    elapsed_s: float
    goal_id: str = ""
    parameters: tuple[tuple[str, str], ...] = ()
    measurements: tuple[tuple[str, str], ...] = ()

    @property
    def has_failed(self) -> bool:
        """Whether it did not succeed; one that was stopped, or found no wire in hand, did not."""
        was_empty = self.ability in EMPTYING and self.error_code in NOTHING_TO_LAY_DOWN
        return self.error_code not in (0, Code.PREEMPTED) and not was_empty


@dataclass(frozen=True)
class Execution:
    """One execution of a wire's behavior.

    Attributes:
        wire: its name.
        behavior: name of the behavior.
        attempt: at placing the wire, from 1; each takes a newly fed wire.
        outcome: of the behavior, or how it ended without one.
        placed: whether the cell's ground truth finds both ends fixed in their terminals.
        started_s: [s] ROS time.
        ended_s: [s] ROS time.
        operations: in the order in which they ended.
    """

    wire: str
    behavior: str
    attempt: int
    outcome: str
    placed: bool
    started_s: float
    ended_s: float
    operations: tuple[Operation, ...]

    @property
    def cell_s(self) -> float:
        """[s] ROS time that it took."""
        return self.ended_s - self.started_s

    @property
    def failures(self) -> tuple[Operation, ...]:
        """The operations that failed."""
        return tuple(each for each in self.operations if each.has_failed)

    def tries(self, ability: str) -> int:
        """Return how often an ability was tried."""
        return sum(operation.ability == ability for operation in self.operations)
