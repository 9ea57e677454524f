"""Do something."""

from flexbe_core import EventState
from scripted_states import script


class StepState(EventState):
    """Do something."""

    def __init__(self):
        super().__init__(outcomes=["done", "failed"])

    on_enter = script.on_enter
    execute = script.execute
