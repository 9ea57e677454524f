"""Gated Test."""

import time
from pathlib import Path

from actionlib.msg import TestAction

from flexbe_core import Autonomy, Behavior, Logger, OperatableStateMachine
from flexbe_core.proxy import ProxyActionClient
from flexbe_states.log_state import LogState

LIMIT_S = 30.0


class GatedSM(Behavior):
    """Prepared as soon as the file `gate` exists.

    It cannot be built if its text is "fail", and waits for a server if that is "wait".
    """

    def __init__(self):
        super().__init__()
        self.name = "Gated Test"
        self.add_parameter("gate", "")

    def create(self):
        gate, limit = Path(self.gate), time.monotonic() + LIMIT_S
        Logger.loginfo("waiting at the gate")
        while not gate.exists() and time.monotonic() < limit:
            time.sleep(0.01)
        if gate.read_text() == "fail":
            raise ValueError("the gate fails")
        if gate.read_text() == "wait":
            ProxyActionClient({"nobody/serves": TestAction}, wait_duration=600.0)
        root = OperatableStateMachine(outcomes=["finished"])
        with root:
            OperatableStateMachine.add(
                "First",
                LogState("first"),
                transitions={"done": "Second"},
                autonomy={"done": Autonomy.Off},
            )
            OperatableStateMachine.add(
                "Second",
                LogState("second"),
                transitions={"done": "finished"},
                autonomy={"done": Autonomy.Off},
            )
        return root
