"""Write many values."""

from flexbe_core import EventState
from scripted_states import script


class SpreadState(EventState):
    """Write many values.

    -- output_keys string[]

    """

    def __init__(self, output_keys):
        super().__init__(outcomes=["done", "failed"], output_keys=output_keys)

    on_enter = script.on_enter
    execute = script.execute
