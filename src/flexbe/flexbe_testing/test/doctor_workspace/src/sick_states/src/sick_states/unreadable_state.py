from flexbe_core import EventState


class UnreadableState(EventState):
    def __init__(  # doctor: app
        self,
        speed: float = 1.0,  # doctor: app
        limits=(0, 1),  # doctor: app
    ):
        super().__init__(outcomes=["all done", "failed"])  # doctor: app
        self._values = speed, limits

    def execute(self, userdata):
        return "failed"
