"""Quick Test."""

from flexbe_core import Autonomy, Behavior, OperatableStateMachine
from flexbe_states.log_state import LogState
from flexbe_states.wait_state import WaitState


class QuickSM(Behavior):
    """Quick Test."""

    def __init__(self):
        super().__init__()
        self.name = "Quick Test"
        self.add_parameter("wait_time", 0.2)
        self.add_parameter("text", "hello")

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add(
                "Say",
                LogState(self.text),
                transitions={"done": "Wait"},
                autonomy={"done": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Wait",
                WaitState(self.wait_time),
                transitions={"done": "finished"},
                autonomy={"done": Autonomy.Off},
            )
        return root
