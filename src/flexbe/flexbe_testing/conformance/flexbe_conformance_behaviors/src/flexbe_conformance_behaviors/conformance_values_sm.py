"""Parameters, inputs and userdata."""

from flexbe_conformance_behaviors.conformance_part_sm import ConformancePartSM
from flexbe_conformance_behaviors.gate_state import GateState
from flexbe_conformance_behaviors.show_state import ShowState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class ConformanceValuesSM(Behavior):
    """Parameters, inputs and userdata."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Values"
        self.add_behavior(ConformancePartSM, "Part")

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"], input_keys=["piece"])
        root.userdata.piece = "nothing"
        with root:
            OperatableStateMachine.add(
                "Part",
                self.use_behavior(ConformancePartSM, "Part"),
                transitions={"finished": "Show"},
                autonomy={"finished": Autonomy.Off},
                remapping={"part": "piece", "label": "tag"},
            )
            OperatableStateMachine.add(
                "Show",
                ShowState(),
                transitions={"done": "Hold"},
                autonomy={"done": Autonomy.Off},
                remapping={"shown": "tag"},
            )
            OperatableStateMachine.add(
                "Hold",
                GateState("hold"),
                transitions={"done": "finished", "other": "finished"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        return root
