"""Call an ability, which keeps its time itself."""

from types import MappingProxyType

from flexbe_core import EventState
from scripted_states import script


class AbilityState(EventState):
    """Call an ability, which keeps its time itself.

    -- timeout_s   float
    -- topic       string

    #> error_code  int

    <= done    [writes pose]
    <= failed  [writes error_code, error_message]

    """

    def __init__(self, timeout_s=5.0, topic="ability"):
        super().__init__(
            outcomes=["done", "failed"],
            input_keys=["target"],
            output_keys=["error_code", "error_message", "pose"],
        )
        self.arguments = {"timeout_s": timeout_s, "topic": topic}

    writes = MappingProxyType({"done": ["pose"], "failed": ["error_code", "error_message"]})
    on_enter = script.on_enter
    execute = script.execute
