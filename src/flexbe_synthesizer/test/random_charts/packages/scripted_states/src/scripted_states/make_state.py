"""Make an item."""

from types import MappingProxyType

from flexbe_core import EventState
from scripted_states import script


class MakeState(EventState):
    """Make an item.

    <= failed  [writes nothing]

    """

    def __init__(self):
        super().__init__(outcomes=["made", "failed"], output_keys=["item"])

    writes = MappingProxyType({"failed": []})
    on_enter = script.on_enter
    execute = script.execute
