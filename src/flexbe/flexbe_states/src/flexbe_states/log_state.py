"""Say something."""

from flexbe_core import EventState, Logger


class LogState(EventState):
    """Tell the operator something.

    -- text      string  What to tell; any object is told as text.
    -- severity  uint8   Type of the message, Logger.REPORT_INFO or another of these.

    <= done  It has been told.

    """

    def __init__(self, text, severity=Logger.REPORT_HINT):
        """Take the text."""
        super().__init__(outcomes=["done"])
        self._text = text
        self._severity = severity

    def on_enter(self, userdata):
        """Tell it."""
        Logger.log(self._text, self._severity)

    def execute(self, userdata):
        """Return at once."""
        return "done"
