"""Say what a value is."""

from flexbe_core import EventState, Logger


class LogKeyState(EventState):
    """Tell the operator a value.

    -- text      string  What to tell; {} stands for the value.
    -- severity  uint8   Type of the message, Logger.REPORT_INFO or another of these.

    ># data  object  The value.

    <= done  It has been told.

    """

    def __init__(self, text, severity=Logger.REPORT_HINT):
        """Take the text."""
        super().__init__(outcomes=["done"], input_keys=["data"])
        self._text = text
        self._severity = severity

    def on_enter(self, userdata):
        """Tell it."""
        Logger.log(self._text.format(userdata.data), self._severity)

    def execute(self, userdata):
        """Return at once."""
        return "done"
