from flexbe_core import EventState, EvntState  # doctor: unknown-import
from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.loopback import Loopback  # doctor: unknown-import
from flexbe_core import proxy
import flexbe_core.nothing  # doctor: unknown-import


class ImportingState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])

    def execute(self, userdata):
        return proxy and OperatableStateMachine and Loopback and flexbe_core.nothing
