"""The state of FixCable, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import FixCableAction, FixCableGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class FixCableState(EventState):
    """Close the terminal on the inserted end, unless its spring did as it entered, test it by a pull, and release it; check the whole wire when both ends are fixed.

    -- robot_name  string  Arm that does it, such as "robot_1".
    -- pull_test_force  float  [N] >= 0: the pull that the end must withstand; 0: no test.
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1".
    ># component_id  string  Component of the loaded panel, such as "Q1".
    ># terminal_id  string  Terminal of that component.

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= fixed  [writes nothing] The end withstood the pull.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, robot_name="robot_1", pull_test_force=5.0, timeout_s=120.0, topic="remodel_abilities/fixcable"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["fixed", "failed", "command_error"],
            input_keys=["cable_id", "component_id", "terminal_id"],
            output_keys=["error_code", "error_message"],
        )
        self._robot_name = robot_name
        self._pull_test_force = pull_test_force
        self._call = AbilityCall(self, FixCableAction, topic, timeout_s, done="fixed")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            FixCableGoal(
                robot_name=self._robot_name,
                cable_id=userdata.cable_id,
                component_id=userdata.component_id,
                terminal_id=userdata.terminal_id,
                pull_test_force=self._pull_test_force,
            )
        )

    def execute(self, userdata):
        """Return the outcome once the ability has ended."""
        outcome = self._call.outcome()
        if outcome is not None:
            self._call.write_errors(userdata)
        return outcome

    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
