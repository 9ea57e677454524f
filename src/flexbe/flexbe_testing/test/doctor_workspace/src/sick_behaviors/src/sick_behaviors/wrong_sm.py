from flexbe_core import Behavior, OperatableStateMachine
from healthy_states.waving_state import WavingState


class Mixin:
    pass


class WrongSM(Mixin, Behavior):  # doctor: app
    def __init__(self):
        super().__init__()
        self.name = "Wrong"

    def create(self, size=1):
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add("Wave", WavingState(), {"done": "finished"})  # doctor: construction
        return root

    def prepare_for_switch(self, state):  # doctor: override
        pass
