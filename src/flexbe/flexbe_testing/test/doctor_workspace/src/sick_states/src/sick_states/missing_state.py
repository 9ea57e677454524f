from flexbe_core import EventState
from no_such_arm.driver import Arm  # doctor: missing-package


class MissingState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])

    def execute(self, userdata):
        return Arm
