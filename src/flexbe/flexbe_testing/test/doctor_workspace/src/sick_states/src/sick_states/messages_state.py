from flexbe_core import EventState
from flexbe_core.proxy import ProxyActionClient, ProxyServiceCaller
from no_such_arm_msgs.msg import MoveAction, MoveGoal  # doctor: missing-messages
from no_such_arm_msgs.srv import Reset


class MessagesState(EventState):
    def __init__(self, speed=MoveGoal.SLOW):
        super().__init__(outcomes=["done"])
        self._client = ProxyActionClient({"move": MoveAction})
        self._service = ProxyServiceCaller({"reset": Reset})
        self._goal = MoveGoal(speed=speed)

    def execute(self, userdata):
        return "done" if self._client.has_result("move") else None
