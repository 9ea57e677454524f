"""Do something, and be exhausted at times."""

from flexbe_core import EventState
from scripted_states import script


class TiredState(EventState):
    """Do something, and be exhausted at times."""

    def __init__(self):
        super().__init__(outcomes=["done", "exhausted"], output_keys=["item"])

    on_enter = script.on_enter
    execute = script.execute
