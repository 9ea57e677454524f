from flexbe_core import EventState, OperatableStateMachine, PriorityContainer


class PrivateState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])
        self._outcome_topic = "/outcome"  # doctor: private
        self._paused = False  # doctor: private
        self._mine = self._outcomes

    def execute(self, userdata):
        if self._last_requested_outcome is None:  # doctor: private
            return self._mine[0]

    def sleep(self):  # doctor: override
        pass

    def on_start(self):
        self.execute = self._other  # doctor: override

    def _other(self, userdata):
        PriorityContainer.active_container = self.path  # doctor: process-wide
        OperatableStateMachine.autonomy_level = 0  # doctor: process-wide


class LoggingMachine(OperatableStateMachine):
    def execute(self, userdata):  # doctor: override
        return super().execute(userdata)
