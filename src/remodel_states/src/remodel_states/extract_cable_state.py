"""The state of ExtractCable, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import ExtractCableAction, ExtractCableGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class ExtractCableState(EventState):
    """Open the terminal, pull the wire's end out, and lay it down in front.

    -- robot_name  string  Arm that does it, such as "robot_1".
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1".
    ># component_id  string  Component of the loaded panel, such as "Q1".
    ># terminal_id  string  Terminal of that component.
    ># socket_pose  geometry_msgs/PoseStamped  Opening from which the end is pulled; frame "world" or "panel" [m].

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= extracted  [writes nothing] The end is out and the gripper empty.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, robot_name="robot_1", timeout_s=30.0, topic="remodel_abilities/extractcable"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["extracted", "failed", "command_error"],
            input_keys=["cable_id", "component_id", "terminal_id", "socket_pose"],
            output_keys=["error_code", "error_message"],
        )
        self._robot_name = robot_name
        self._call = AbilityCall(self, ExtractCableAction, topic, timeout_s, done="extracted")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            ExtractCableGoal(
                robot_name=self._robot_name,
                cable_id=userdata.cable_id,
                component_id=userdata.component_id,
                terminal_id=userdata.terminal_id,
                socket_pose=userdata.socket_pose,
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
