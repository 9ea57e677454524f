from flexbe_core import EventState
from no_such_arm.driver import Arm  # doctor: missing-package


class MissingState(EventState):
    def execute(self, userdata):
        return Arm
