"""Log a text."""

from flexbe_core import EventState, Logger


class LogState(EventState):
    """Log a text for the operator.

    -- text      string  Text to log; any other object is converted to text.
    -- severity  uint8   Type of the message, Logger.REPORT_INFO or another of these.

    <= done  The text has been logged.

    """

    def __init__(self, text, severity=Logger.REPORT_HINT):
        super().__init__(outcomes=["done"])
        self._text = text
        self._severity = severity

    def on_enter(self, userdata):
        """Log the text."""
        Logger.log(self._text, self._severity)

    def execute(self, userdata):
        """Return at once."""
        return "done"
