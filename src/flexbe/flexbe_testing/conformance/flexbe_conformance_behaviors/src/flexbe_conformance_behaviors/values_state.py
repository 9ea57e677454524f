"""A state that logs the values it was given."""

import json

from flexbe_core import EventState, Logger


class ValuesState(EventState):
    """Log parameters and userdata as JSON, and write userdata.

    -- values  dict  What to log.

    ># part   object  A value with an attribute `pins`, or a text.
    #> label  string  The text "made of " and the input.

    <= done  Always.

    """

    def __init__(self, values):
        """Remember what to log."""
        super().__init__(outcomes=["done"], input_keys=["part"], output_keys=["label"])
        self._values = values

    def execute(self, userdata):
        """Return at once."""
        return "done"

    def on_enter(self, userdata):
        """Log, and write the output."""
        part = userdata.part
        found = {**self._values, "part": str(part), "pins": getattr(part, "pins", None)}
        Logger.loginfo("conformance: values %s", json.dumps(found, sort_keys=True))
        userdata.label = f"made of {part}"
