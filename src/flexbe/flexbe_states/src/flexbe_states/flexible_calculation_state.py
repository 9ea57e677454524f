"""Calculate from several values."""

from flexbe_core import EventState, Logger


class FlexibleCalculationState(EventState):
    """Apply a function to values.

    -- calculation  function  Function with keyword arguments named as the keys; returns the result.
    -- input_keys   string[]  Keys of the arguments.

    ># input_keys  object[]  Arguments of the function.

    #> output_value  object  Result of the function; None if it fails.

    <= done  The function has been applied.

    """

    def __init__(self, calculation, input_keys):
        super().__init__(outcomes=["done"], input_keys=input_keys, output_keys=["output_value"])
        self._calculation = calculation
        self._calculation_result = None

    def on_enter(self, userdata):
        """Apply the function."""
        self._calculation_result = None
        if self._calculation is None:
            Logger.logwarn("%s: there is no function to apply", self.name)
            return
        try:
            arguments = {key: userdata[key] for key in self.input_keys}
            self._calculation_result = self._calculation(**arguments)
        except Exception as error:  # noqa: BLE001 - the function is the user's
            Logger.logwarn("%s: the function failed: %s", self.name, error)

    def execute(self, userdata):
        """Write the result to userdata."""
        userdata.output_value = self._calculation_result
        return "done"
