"""A gate beside a priority container."""

from flexbe_conformance_behaviors.gate_state import GateState
from flexbe_core import (
    Autonomy,
    Behavior,
    ConcurrencyContainer,
    OperatableStateMachine,
    PriorityContainer,
)


class ConformancePrioritySM(Behavior):
    """A gate beside a priority container."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Priority"

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        both = ConcurrencyContainer(
            outcomes=["all"],
            conditions=[("all", [("Calm", "done"), ("Watch", "over")])],
        )
        watch = OperatableStateMachine(outcomes=["over"])
        alarm = PriorityContainer(outcomes=["handled"])
        with alarm:
            OperatableStateMachine.add(
                "Act",
                GateState("act"),
                transitions={"done": "handled", "other": "handled"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        with watch:
            OperatableStateMachine.add(
                "Wait",
                GateState("wait"),
                transitions={"done": "Alarm", "other": "over"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Alarm",
                alarm,
                transitions={"handled": "over"},
                autonomy={"handled": Autonomy.Off},
            )
        with both:
            OperatableStateMachine.add(
                "Calm",
                GateState("calm"),
                transitions={"done": "all", "other": "all"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Watch",
                watch,
                transitions={"over": "all"},
                autonomy={"over": Autonomy.Off},
            )
        with root:
            OperatableStateMachine.add(
                "Both",
                both,
                transitions={"all": "finished"},
                autonomy={"all": Autonomy.Off},
            )
        return root
