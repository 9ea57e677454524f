"""Let the operator decide."""

from flexbe_core import EventState, Logger


class OperatorDecisionState(EventState):
    """Let the operator choose the outcome.

    -- outcomes    string[]  The outcomes to choose from.
    -- hint        string    Hint for the operator, logged on entry; None for no hint.
    -- suggestion  string    Outcome that is taken if autonomy allows; None always waits.

    """

    def __init__(self, outcomes, hint=None, suggestion=None):
        super().__init__(outcomes=outcomes)
        self._hint = hint
        self._suggestion = suggestion

    def on_enter(self, userdata):
        """Log the hint."""
        if self._hint is not None:
            Logger.loghint(self._hint)

    def execute(self, userdata):
        """Return the suggestion, if it is one of the outcomes."""
        return self._suggestion if self._suggestion in self.outcomes else None
