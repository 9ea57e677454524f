"""Check a condition on several values."""

from flexbe_core import EventState, Logger


class FlexibleCheckConditionState(EventState):
    """Apply a predicate to values.

    -- predicate   function  Function of one list, the values in the order of the keys.
    -- input_keys  string[]  Keys of the values.

    ># input_keys  object[]  The values.

    <= true   The predicate returned true.
    <= false  The predicate returned false. If it fails, its last result counts, false at first.

    """

    def __init__(self, predicate, input_keys):
        super().__init__(outcomes=["true", "false"], input_keys=input_keys)
        self._predicate = predicate
        self._outcome = "false"

    def on_enter(self, userdata):
        """Apply the predicate."""
        try:
            values = [userdata[key] for key in self.input_keys]
            self._outcome = "true" if self._predicate(values) else "false"
        except Exception as error:  # noqa: BLE001 - the predicate is the user's
            Logger.logwarn("%s: the predicate failed: %s", self.name, error)

    def execute(self, userdata):
        """Return the result."""
        return self._outcome
