"""A state or behavior that raises."""

from flexbe_conformance_behaviors.fault_state import FaultState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class ConformanceFaultSM(Behavior):
    """A state or behavior that raises."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Fault"
        self.add_parameter("how", "execute")

    def create(self):
        if self.how == "create":
            raise RuntimeError("raised on purpose in create")
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add(
                "Fault",
                FaultState(self.how),
                transitions={"done": "finished"},
                autonomy={"done": Autonomy.Off},
            )
        return root
