"""Call an ability, which keeps its time itself."""

from flexbe_core import EventState
from scripted_states import script


class AbilityState(EventState):
    """Call an ability, which keeps its time itself.

    -- timeout_s   float
    -- topic       string

    #> error_code  int

    """

    def __init__(self, timeout_s=5.0, topic="ability"):
        super().__init__(
            outcomes=["done", "failed"],
            input_keys=["target"],
            output_keys=["error_code", "error_message", "pose"],
        )
        self.arguments = {"timeout_s": timeout_s, "topic": topic}

    on_enter = script.on_enter
    execute = script.execute
