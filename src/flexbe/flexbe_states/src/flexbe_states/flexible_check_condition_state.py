"""Check a condition on several values."""

from flexbe_core import EventState, Logger


class FlexibleCheckConditionState(EventState):
    """Ask a predicate about values.

    -- predicate   function  Function of one list, the values in the order of the keys.
    -- input_keys  string[]  Keys of the values.

    ># input_keys  object[]  The values.

    <= true   The predicate says so.
    <= false  The predicate denies it. If it fails, the last answer counts, false at first.

    """

    def __init__(self, predicate, input_keys):
        """Take the predicate."""
        super().__init__(outcomes=["true", "false"], input_keys=input_keys)
        self._predicate = predicate
        self._outcome = "false"

    def on_enter(self, userdata):
        """Ask the predicate."""
        try:
            values = [userdata[key] for key in self.input_keys]
            self._outcome = "true" if self._predicate(values) else "false"
        except Exception as error:  # noqa: BLE001 - the predicate is the user's
            Logger.logwarn("%s: the predicate failed: %s", self.name, error)

    def execute(self, userdata):
        """Return the answer."""
        return self._outcome
