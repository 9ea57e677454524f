from flexbe_core import EventState


class RaisingState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])
        self._first = [][0]  # doctor: construction

    def execute(self, userdata):
        return "done"
