"""Try something, with a timeout among its own outcomes."""

from flexbe_core import EventState
from scripted_states import script


class TryState(EventState):
    """Try something, with a timeout among its own outcomes.

    #> error_code int

    """

    def __init__(self):
        super().__init__(outcomes=["done", "failed", "timed_out"], output_keys=["error_code"])

    on_enter = script.on_enter
    execute = script.execute
