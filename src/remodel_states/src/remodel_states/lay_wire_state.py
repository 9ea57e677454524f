"""The state of LayWire, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import LayWireAction, LayWireGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class LayWireState(EventState):
    """Lead a wire along its route into the ducts with one robot while another holds its free end.

    -- robot_name  string  Arm that holds the free end, such as "robot_2".
    -- guide_name  string  Arm whose eyelet leads the wire, another one, its hand empty, such as "robot_1".
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1"; one end fixed, the other one held.

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= laid  [writes nothing] The wire is led into its ducts, its free end held.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, robot_name="robot_2", guide_name="robot_1", timeout_s=180.0, topic="remodel_abilities/laywire"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["laid", "failed", "command_error"],
            input_keys=["cable_id"],
            output_keys=["error_code", "error_message"],
        )
        self._robot_name = robot_name
        self._guide_name = guide_name
        self._call = AbilityCall(self, LayWireAction, topic, timeout_s, done="laid")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            LayWireGoal(
                robot_name=self._robot_name,
                guide_name=self._guide_name,
                cable_id=userdata.cable_id,
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
