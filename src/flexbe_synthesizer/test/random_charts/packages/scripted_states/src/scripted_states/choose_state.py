"""Choose one of many outcomes."""

from flexbe_core import EventState
from scripted_states import script


class ChooseState(EventState):
    """Choose one of many outcomes.

    -- outcomes string[]

    """

    def __init__(self, outcomes):
        super().__init__(outcomes=outcomes)

    on_enter = script.on_enter
    execute = script.execute
