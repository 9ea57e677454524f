"""Goal Test."""

from engine_test_behaviors.goal_state import GoalState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class GoalSM(Behavior):
    """Goal Test."""

    def __init__(self):
        super().__init__()
        self.name = "Goal Test"
        self.add_parameter("topic", "test_action")
        self.add_parameter("watch", True)
        self.add_parameter("rate", 10.0)

    def create(self):
        root = OperatableStateMachine(outcomes=["finished", "failed"])
        with root:
            OperatableStateMachine.add(
                "Goal",
                GoalState(self.topic, self.watch, self.rate),
                transitions={"done": "finished", "failed": "failed"},
                autonomy={"done": Autonomy.Off, "failed": Autonomy.Off},
            )
        return root
