"""Input Test."""

from flexbe_core import Autonomy, Behavior, OperatableStateMachine
from flexbe_states.flexible_calculation_state import FlexibleCalculationState
from flexbe_states.log_key_state import LogKeyState
from flexbe_states.wait_state import WaitState


class InputSM(Behavior):
    """Input Test."""

    def __init__(self):
        super().__init__()
        self.name = "Input Test"
        self.add_parameter("wait_time", 0.0)

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"], input_keys=["part", "name"])
        root.userdata.part = None
        root.userdata.name = "nobody"
        with root:
            OperatableStateMachine.add(
                "Join",
                FlexibleCalculationState(
                    lambda part, name: f"pins {part.pins} of {name}", ["part", "name"]
                ),
                transitions={"done": "Say"},
                autonomy={"done": Autonomy.Off},
                remapping={"output_value": "text"},
            )
            OperatableStateMachine.add(
                "Say",
                LogKeyState("{}"),
                transitions={"done": "Wait"},
                autonomy={"done": Autonomy.Off},
                remapping={"data": "text"},
            )
            OperatableStateMachine.add(
                "Wait",
                WaitState(self.wait_time),
                transitions={"done": "finished"},
                autonomy={"done": Autonomy.Off},
            )
        return root
