"""Gates in nested containers."""

from flexbe_conformance_behaviors.gate_state import GateState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class ConformanceNestSM(Behavior):
    """Gates in nested containers."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Nest"

    def create(self):
        root = OperatableStateMachine(outcomes=["finished", "failed"])
        inner = OperatableStateMachine(outcomes=["left"])
        box = OperatableStateMachine(outcomes=["ok", "bad"])
        with inner:
            OperatableStateMachine.add(
                "Leaf",
                GateState("leaf"),
                transitions={"done": "Tail", "other": "left"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Tail",
                GateState("tail"),
                transitions={"done": "left", "other": "Leaf"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        with box:
            OperatableStateMachine.add(
                "Inner",
                inner,
                transitions={"left": "Last"},
                autonomy={"left": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Last",
                GateState("last"),
                transitions={"done": "ok", "other": "bad"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        with root:
            OperatableStateMachine.add(
                "Box",
                box,
                transitions={"ok": "After", "bad": "failed"},
                autonomy={"ok": Autonomy.Off, "bad": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "After",
                GateState("after"),
                transitions={"done": "finished", "other": "Box"},
                autonomy={"done": Autonomy.Off, "other": Autonomy.Off},
            )
        return root
