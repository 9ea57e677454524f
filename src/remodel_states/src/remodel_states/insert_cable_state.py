"""The state of InsertCable, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import InsertCableAction, InsertCableGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class InsertCableState(EventState):
    """Push one end of a wire into a terminal until it seats; picks it first when the gripper is empty.

    -- robot_name  string  Arm that does it, such as "robot_1".
    -- force_limit  float  [N] > 0: axial force at which the push stops.
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1".
    ># cable_end  string  "a" or "b".
    ># component_id  string  Component of the loaded panel, such as "Q1".
    ># terminal_id  string  Terminal of that component.
    ># socket_pose  geometry_msgs/PoseStamped  As LocateGearboxComponent returns it; frame "world" or "panel" [m].

    #> depth  float  [m] from the opening to the tip, as measured by the arm.
    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= inserted  [writes depth] The end sits at the bottom of the terminal.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, robot_name="robot_1", force_limit=8.0, timeout_s=60.0, topic="remodel_abilities/insertcable"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["inserted", "failed", "command_error"],
            input_keys=["cable_id", "cable_end", "component_id", "terminal_id", "socket_pose"],
            output_keys=["depth", "error_code", "error_message"],
        )
        self._robot_name = robot_name
        self._force_limit = force_limit
        self._call = AbilityCall(self, InsertCableAction, topic, timeout_s, done="inserted")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            InsertCableGoal(
                robot_name=self._robot_name,
                cable_id=userdata.cable_id,
                cable_end=userdata.cable_end,
                component_id=userdata.component_id,
                terminal_id=userdata.terminal_id,
                socket_pose=userdata.socket_pose,
                force_limit=self._force_limit,
            )
        )

    def execute(self, userdata):
        """Return the outcome once the ability has ended."""
        outcome = self._call.outcome()
        if outcome is not None:
            self._call.write_errors(userdata)
        if outcome == "inserted":
            userdata.depth = self._call.result.depth
        return outcome

    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
