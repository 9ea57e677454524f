"""Limit the attempts of a part of a behavior."""

from flexbe_core import EventState


class CountAttemptsState(EventState):
    """Count one more attempt and check whether it is still allowed.

    The synthesizer puts it before a state that has `ext:attempts`.

    -- attempts  int  Number of attempts allowed, at least 1.

    ># attempt   int  Attempts so far.
    #> attempt   int  Attempts including this one.

    <= counted        The attempt is allowed.
    <= exhausted      All attempts have been made.

    """

    def __init__(self, attempts):
        """Check the bound.

        Raises:
            ValueError: if attempts is not an integer of at least 1.
        """
        super().__init__(
            outcomes=["counted", "exhausted"], input_keys=["attempt"], output_keys=["attempt"]
        )
        if not isinstance(attempts, int) or attempts < 1:
            raise ValueError(f"attempts must be an integer of at least 1, found {attempts!r}")
        self._attempts = attempts
        self._outcome = None

    def on_enter(self, userdata):
        """Count: once for each visit, however long the operator withholds the outcome."""
        attempt = userdata.attempt + 1
        userdata.attempt = attempt
        self._outcome = "counted" if attempt <= self._attempts else "exhausted"

    def execute(self, userdata):
        """Return at once."""
        return self._outcome
