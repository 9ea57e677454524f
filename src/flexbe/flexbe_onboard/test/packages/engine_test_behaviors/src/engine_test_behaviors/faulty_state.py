"""Go wrong."""

from flexbe_core import EventState


class FaultyState(EventState):
    """Raise, or return an outcome that is not declared.

    -- how  string  "raise" or "undeclared".

    <= done  Never.

    """

    def __init__(self, how):
        """Take the way."""
        super().__init__(outcomes=["done"])
        self._how = how

    def execute(self, userdata):
        """Go wrong."""
        if self._how == "raise":
            raise RuntimeError("no camera image")
        return "undeclared"
