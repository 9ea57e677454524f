from flexbe_core import EventState


class CheckConditionState(EventState):
    """Ask a predicate.

    -- predicate    function  is asked
    ># input_value  object    what it is asked about
    <= true   it says so
    <= false  it denies it
    """

    def __init__(self, predicate):
        super().__init__(outcomes=["true", "false"], input_keys=["input_value"])
