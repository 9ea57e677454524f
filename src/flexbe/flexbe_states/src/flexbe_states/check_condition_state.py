"""Check a condition."""

from flexbe_core import EventState, Logger


class CheckConditionState(EventState):
    """Apply a predicate to a value.

    -- predicate  function  Function of one argument; returns true or false.

    ># input_value  object  Argument of the predicate.

    <= true   The predicate returned true.
    <= false  The predicate returned false. If it fails, its last result counts, false at first.

    """

    def __init__(self, predicate):
        super().__init__(outcomes=["true", "false"], input_keys=["input_value"])
        self._predicate = predicate
        self._outcome = "false"

    def on_enter(self, userdata):
        """Apply the predicate."""
        try:
            self._outcome = "true" if self._predicate(userdata.input_value) else "false"
        except Exception as error:  # noqa: BLE001 - the predicate is the user's
            Logger.logwarn("%s: the predicate failed: %s", self.name, error)

    def execute(self, userdata):
        """Return the result."""
        return self._outcome
