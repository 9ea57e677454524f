"""The behavior within Conformance Values."""

from flexbe_conformance_behaviors.values_state import ValuesState
from flexbe_core import Autonomy, Behavior, OperatableStateMachine


class ConformancePartSM(Behavior):
    """The behavior within Conformance Values."""

    def __init__(self):
        super().__init__()
        self.name = "Conformance Part"
        self.add_parameter("word", "part")
        self.add_parameter("size", 1.5)
        self.add_parameter("count", 2)
        self.add_parameter("is_new", True)

    def create(self):
        root = OperatableStateMachine(
            outcomes=["finished"], input_keys=["part"], output_keys=["label"]
        )
        values = {
            "word": self.word,
            "size": self.size,
            "count": self.count,
            "is_new": self.is_new,
        }
        with root:
            OperatableStateMachine.add(
                "Values",
                ValuesState(values),
                transitions={"done": "finished"},
                autonomy={"done": Autonomy.Off},
                remapping={"part": "part", "label": "label"},
            )
        return root
