"""Provide a constant."""

from flexbe_core import EventState


class UserDataState(EventState):
    """Put a value into userdata.

    -- data  object  The value.

    #> data  object  The value.

    <= done  The value has been written.

    """

    def __init__(self, data):
        super().__init__(outcomes=["done"], output_keys=["data"])
        self._data = data

    def on_enter(self, userdata):
        """Write the value to userdata."""
        userdata.data = self._data

    def execute(self, userdata):
        """Return at once."""
        return "done"
