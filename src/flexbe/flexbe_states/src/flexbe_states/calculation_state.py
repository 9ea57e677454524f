"""Calculate."""

from flexbe_core import EventState, Logger


class CalculationState(EventState):
    """Apply a function to a value.

    -- calculation  function  Function of one argument; returns the result.

    ># input_value  object  Argument of the function.

    #> output_value  object  Result of the function; None if it fails.

    <= done  The function has been applied.

    """

    def __init__(self, calculation):
        super().__init__(
            outcomes=["done"], input_keys=["input_value"], output_keys=["output_value"]
        )
        self._calculation = calculation
        self._calculation_result = None

    def on_enter(self, userdata):
        """Apply the function."""
        self._calculation_result = None
        if self._calculation is None:
            Logger.logwarn("%s: there is no function to apply", self.name)
            return
        try:
            self._calculation_result = self._calculation(userdata.input_value)
        except Exception as error:  # noqa: BLE001 - the function is the user's
            Logger.logwarn("%s: the function failed: %s", self.name, error)

    def execute(self, userdata):
        """Write the result to userdata."""
        userdata.output_value = self._calculation_result
        return "done"
