from flexbe_core import EventState


class DecisionState(EventState):
    """Let a function choose.

    -- outcomes     string[]  what can be chosen
    -- conditions   function  chooses
    ># input_value  object    what it looks at
    """

    def __init__(self, outcomes, conditions):
        super().__init__(outcomes=outcomes, input_keys=["input_value"])
