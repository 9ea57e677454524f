from flexbe_core import EventState


class UnreadableState(EventState):
    def __init__(  # doctor: app
        self,
        speed: float = 1.0,
        limits=(0, 1),
    ):
        super().__init__(outcomes=["all done", "failed"])
        self._values = speed, limits

    def execute(self, userdata):
        return "failed"
