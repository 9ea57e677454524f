"""Read many values."""

from flexbe_core import EventState
from scripted_states import script


class GatherState(EventState):
    """Read many values.

    -- input_keys string[]

    """

    def __init__(self, input_keys):
        super().__init__(outcomes=["done"], input_keys=input_keys)

    on_enter = script.on_enter
    execute = script.execute
