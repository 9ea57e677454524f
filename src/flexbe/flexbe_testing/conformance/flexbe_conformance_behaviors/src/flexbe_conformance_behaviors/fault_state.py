"""A state that raises."""

from flexbe_core import EventState, Logger


class FaultState(EventState):
    """Raise in one of its methods.

    -- how  string  "execute", "enter" or "start".

    <= done  It did not raise.

    """

    def __init__(self, how):
        """Remember where to raise."""
        super().__init__(outcomes=["done"])
        self._how = how

    def execute(self, userdata):
        """Raise, or stay."""
        self._raise_if("execute")

    def on_start(self):
        """Raise, or do nothing."""
        self._raise_if("start")

    def on_enter(self, userdata):
        """Raise, or do nothing."""
        Logger.loginfo("conformance: enter %s", self.path)
        self._raise_if("enter")

    def on_stop(self):
        """Log the event."""
        Logger.loginfo("conformance: stop %s", self.path)

    def _raise_if(self, method):
        if self._how == method:
            raise RuntimeError(f"raised on purpose in {method}")
