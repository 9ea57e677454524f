"""Make a result of an item."""

from flexbe_core import EventState
from scripted_states import script


class TurnState(EventState):
    """Make a result of an item."""

    def __init__(self):
        super().__init__(
            outcomes=["turned", "not turned"], input_keys=["item"], output_keys=["result"]
        )

    on_enter = script.on_enter
    execute = script.execute
