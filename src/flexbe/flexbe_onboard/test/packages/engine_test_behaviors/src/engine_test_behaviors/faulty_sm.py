"""Faulty Test."""

from engine_test_behaviors.faulty_state import FaultyState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class FaultySM(Behavior):
    """Faulty Test."""

    def __init__(self):
        super().__init__()
        self.name = "Faulty Test"
        self.add_parameter("how", "raise")
        self.add_parameter("hang_s", 60.0)

    def create(self):
        if self.how == "build":
            raise ValueError("nothing to build from")
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add(
                "Faulty",
                FaultyState(self.how, self.hang_s),
                transitions={"done": "finished"},
                autonomy={"done": Autonomy.Off},
            )
        return root
