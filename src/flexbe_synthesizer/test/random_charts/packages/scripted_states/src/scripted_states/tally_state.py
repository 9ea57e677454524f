"""Change a count in its place."""

from flexbe_core import EventState
from scripted_states import script


class TallyState(EventState):
    """Change a count in its place.

    ># count int
    #> count int

    """

    def __init__(self):
        super().__init__(outcomes=["more", "enough"], input_keys=["count"], output_keys=["count"])

    on_enter = script.on_enter
    execute = script.execute
