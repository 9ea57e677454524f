"""Go wrong."""

import time

from flexbe_core import EventState


class FaultyState(EventState):
    """Raise, or hang.

    -- how  string  "raise" or "hang".
    -- hang_s  float  How long it hangs.

    <= done  It hung, and returned after all.

    """

    def __init__(self, how, hang_s=60.0):
        """Take the way."""
        super().__init__(outcomes=["done"])
        self._how = how
        self._hang_s = hang_s

    def execute(self, userdata):
        """Go wrong."""
        if self._how == "raise":
            raise RuntimeError("no camera image")
        time.sleep(self._hang_s)
        return "done"
