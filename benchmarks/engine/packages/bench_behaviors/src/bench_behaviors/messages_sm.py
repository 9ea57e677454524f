"""Bench Messages."""
# ruff: noqa: ANN201, ANN204, D102

from bench_behaviors.states import MessageState
from flexbe_core import Behavior, OperatableStateMachine


class MessagesSM(Behavior):
    """Bench Messages."""

    def __init__(self):
        super().__init__()
        self.name = "Bench Messages"
        self.add_parameter("count", 10)

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add(
                "Loop",
                MessageState(self.count),
                transitions={"again": "Loop", "done": "finished"},
                autonomy={"again": 0, "done": 0},
            )
        return root
