"""Bench Waits."""
# ruff: noqa: ANN201, ANN204, D102

from bench_behaviors.states import LoopState, OvershootState
from flexbe_core import Behavior, OperatableStateMachine
from flexbe_states.wait_state import WaitState


class WaitsSM(Behavior):
    """Bench Waits."""

    def __init__(self):
        super().__init__()
        self.name = "Bench Waits"
        self.add_parameter("count", 10)
        self.add_parameter("wait_s", 0.13)

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add("Mark", OvershootState(self.wait_s), {"done": "Wait"})
            OperatableStateMachine.add("Wait", WaitState(self.wait_s), {"done": "Loop"})
            OperatableStateMachine.add(
                "Loop", LoopState(self.count), {"again": "Mark", "done": "finished"}
            )
        return root
