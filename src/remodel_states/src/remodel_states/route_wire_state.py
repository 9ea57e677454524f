"""The state of RouteWire, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import RouteWireAction, RouteWireGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall
from remodel_states.parameters import panel_pose


class RouteWireState(EventState):
    """Carry the held end of a wire along a path.

    -- path  list  [[x, y, z, yaw], ...] in the panel frame [m, rad], of the tool centre.
    -- robot_name  string  Arm that does it, such as "robot_1".
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1".

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= routed  [writes nothing] The end is at the last pose, held.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, path, robot_name="robot_1", timeout_s=30.0, topic="remodel_abilities/routewire"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["routed", "failed", "command_error"],
            input_keys=["cable_id"],
            output_keys=["error_code", "error_message"],
        )
        self._path = path
        self._robot_name = robot_name
        self._call = AbilityCall(self, RouteWireAction, topic, timeout_s, done="routed")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            RouteWireGoal(
                robot_name=self._robot_name,
                cable_id=userdata.cable_id,
                path=[panel_pose(pose) for pose in self._path],
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
