"""Log a value."""

from flexbe_core import EventState, Logger


class LogKeyState(EventState):
    """Log a value for the operator.

    -- text      string  Text to log; {} stands for the value.
    -- severity  uint8   Type of the message, Logger.REPORT_INFO or another of these.

    ># data  object  The value.

    <= done  The text has been logged.

    """

    def __init__(self, text, severity=Logger.REPORT_HINT):
        super().__init__(outcomes=["done"], input_keys=["data"])
        self._text = text
        self._severity = severity

    def on_enter(self, userdata):
        """Log the text."""
        Logger.log(self._text.format(userdata.data), self._severity)

    def execute(self, userdata):
        """Return at once."""
        return "done"
