"""A state that logs a value from the userdata."""

from flexbe_core import EventState, Logger


class ShowState(EventState):
    """Log a userdata value.

    ># shown  object  The value.

    <= done  Always.

    """

    def __init__(self):
        """Declare the key."""
        super().__init__(outcomes=["done"], input_keys=["shown"])

    def execute(self, userdata):
        """Return at once."""
        return "done"

    def on_enter(self, userdata):
        """Log the value."""
        Logger.loginfo("conformance: shown %s", userdata.shown)
