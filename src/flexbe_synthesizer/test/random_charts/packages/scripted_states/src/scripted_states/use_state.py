"""Use an item."""

from flexbe_core import EventState
from scripted_states import script


class UseState(EventState):
    """Use an item."""

    def __init__(self):
        super().__init__(outcomes=["used", "refused"], input_keys=["item"])

    on_enter = script.on_enter
    execute = script.execute
