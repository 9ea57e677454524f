from flexbe_core import Autonomy, Behavior, OperatableStateMachine
from healthy_states.waving_state import WavingState


class LostSM(Behavior):  # doctor: construction # doctor: app
    def __init__(self):
        super().__init__()
        self.name = "Lost"

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        box = OperatableStateMachine(outcomes=["done"])
        with box:
            OperatableStateMachine.add(
                "Wave", WavingState(3), transitions={"done": "Nowhere"}, autonomy={"done": Autonomy.Off}
            )
        with root:
            OperatableStateMachine.add("Box", box, transitions={"done": "finished"})
        return root
