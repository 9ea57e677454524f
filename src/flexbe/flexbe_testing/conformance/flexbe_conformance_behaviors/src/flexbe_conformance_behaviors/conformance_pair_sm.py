"""Two gates at once, then a third."""

from flexbe_conformance_behaviors.gate_state import GateState
from flexbe_core import Autonomy, Behavior, ConcurrencyContainer, OperatableStateMachine


class ConformancePairSM(Behavior):
    """Two gates at once, then a third."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Pair"

    def create(self):
        root = OperatableStateMachine(outcomes=["finished", "failed"])
        both = ConcurrencyContainer(
            outcomes=["all", "either"],
            conditions=[
                ("all", [("Left", "done"), ("Right", "done")]),
                ("either", [("Left", "other")]),
                ("either", [("Right", "other")]),
            ],
        )
        with both:
            OperatableStateMachine.add(
                "Left",
                GateState("left"),
                transitions={"done": "all", "other": "either"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Right",
                GateState("right"),
                transitions={"done": "all", "other": "either"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        with root:
            OperatableStateMachine.add(
                "Both",
                both,
                transitions={"all": "After", "either": "failed"},
                autonomy={"all": Autonomy.Off, "either": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "After",
                GateState("after"),
                transitions={"done": "finished", "other": "failed"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        return root
