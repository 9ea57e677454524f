"""Two gates, one after the other."""

from flexbe_conformance_behaviors.gate_state import GateState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class ConformanceChainSM(Behavior):
    """Two gates, one after the other."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Chain"

    def create(self):
        root = OperatableStateMachine(outcomes=["finished", "failed"])
        with root:
            OperatableStateMachine.add(
                "First",
                GateState("first"),
                transitions={"done": "Second", "other": "failed"},
                autonomy={"done": Autonomy.Low, "other": Autonomy.Full},
            )
            OperatableStateMachine.add(
                "Second",
                GateState("second"),
                transitions={"done": "finished", "other": "First"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.High},
            )
        return root
