"""Make an item."""

from flexbe_core import EventState
from scripted_states import script


class MakeState(EventState):
    """Make an item."""

    def __init__(self):
        super().__init__(outcomes=["made", "failed"], output_keys=["item"])

    on_enter = script.on_enter
    execute = script.execute
