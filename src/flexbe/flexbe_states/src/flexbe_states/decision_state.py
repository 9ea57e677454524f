"""Decide by a function."""

from flexbe_core import EventState, Logger


class DecisionState(EventState):
    """Let a function choose the outcome.

    -- outcomes    string[]  The outcomes to choose from.
    -- conditions  function  Function of one argument; returns one of the outcomes, or anything else
                             to be called again.

    ># input_value  object  Argument of the function.

    """

    def __init__(self, outcomes, conditions):
        """Take the function."""
        super().__init__(outcomes=outcomes, input_keys=["input_value"])
        self._conditions = conditions
        self._warned = False

    def on_enter(self, userdata):
        """Warn once per visit if the function fails."""
        self._warned = False

    def execute(self, userdata):
        """Call the function."""
        try:
            outcome = str(self._conditions(userdata.input_value))
        except Exception as error:  # noqa: BLE001 - the function is the user's
            if not self._warned:
                self._warned = True
                Logger.logwarn("%s: the function failed: %s", self.name, error)
            return None
        return outcome if outcome in self.outcomes else None
