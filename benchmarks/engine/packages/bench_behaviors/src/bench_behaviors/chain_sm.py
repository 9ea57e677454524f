"""Bench Chain."""
# ruff: noqa: ANN201, ANN204, D102

from bench_behaviors.states import LoopState, MarkState, NothingState
from flexbe_core import Behavior, OperatableStateMachine


class ChainSM(Behavior):
    """Bench Chain."""

    def __init__(self):
        super().__init__()
        self.name = "Bench Chain"
        self.add_parameter("states", 10)
        self.add_parameter("rounds", 1)

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        labels = [f"State {index}" for index in range(self.states)]
        with root:
            OperatableStateMachine.add("Begin", MarkState(), {"done": labels[0]})
            for label, following in zip(labels, [*labels[1:], "Loop"], strict=True):
                OperatableStateMachine.add(label, NothingState(), {"done": following})
            OperatableStateMachine.add(
                "Loop", LoopState(self.rounds), {"again": labels[0], "done": "End"}
            )
            OperatableStateMachine.add("End", MarkState(), {"done": "finished"})
        return root
