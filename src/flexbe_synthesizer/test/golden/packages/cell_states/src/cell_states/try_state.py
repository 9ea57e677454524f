from flexbe_core import EventState


class TryState(EventState):
    """Try something that may fail.

    #> value         int     what came out of it
    #> error_code    int     why nothing did

    <= done          [writes value] it worked
    <= given up      [writes nothing] it was not tried
    <= failed        it did not work
        [writes error_code]
    """

    def __init__(self):
        super().__init__(
            outcomes=["done", "given up", "failed"], output_keys=["value", "error_code"]
        )
