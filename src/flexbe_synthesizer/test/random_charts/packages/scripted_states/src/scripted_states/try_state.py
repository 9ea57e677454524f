"""Try something, with a timeout among its own outcomes."""

from types import MappingProxyType

from flexbe_core import EventState
from scripted_states import script


class TryState(EventState):
    """Try something, with a timeout among its own outcomes.

    #> error_code int

    <= done       [writes nothing]
    <= failed     [writes error_code]
    <= timed_out

    """

    def __init__(self):
        super().__init__(outcomes=["done", "failed", "timed_out"], output_keys=["error_code"])

    writes = MappingProxyType({"done": []})
    on_enter = script.on_enter
    execute = script.execute
