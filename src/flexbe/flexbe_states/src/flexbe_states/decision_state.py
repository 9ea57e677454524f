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
        super().__init__(outcomes=outcomes, input_keys=["input_value"])
        self._conditions = conditions
        self._warned = False
        self._outcome = None

    def on_enter(self, userdata):
        """Decide once per visit, and warn once if the function fails."""
        self._warned = False
        self._outcome = None

    def execute(self, userdata):
        """Call the function until it has named an outcome."""
        if self._outcome is not None:
            return self._outcome
        try:
            outcome = str(self._conditions(userdata.input_value))
        except Exception as error:  # noqa: BLE001 - the function is the user's
            if not self._warned:
                self._warned = True
                Logger.logwarn("%s: the function failed: %s", self.name, error)
            return None
        self._outcome = outcome if outcome in self.outcomes else None
        return self._outcome
