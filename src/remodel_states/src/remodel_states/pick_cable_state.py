"""The state of PickCable, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import PickCableAction, PickCableGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class PickCableState(EventState):
    """Grasp a wire behind one of its loose ends, by friction, and lift it.

    -- robot_name  string  Arm that picks, such as "robot_1".
    -- grasp_distance  float  [m] from the tip to the centre of the grasp, along the wire; 0: the cell's default.
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1".
    ># cable_end  string  "a" or "b".

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= picked  [writes nothing] The wire is held and lifted.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, robot_name="robot_1", grasp_distance=0.0, timeout_s=30.0, topic="remodel_abilities/pickcable"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["picked", "failed", "command_error"],
            input_keys=["cable_id", "cable_end"],
            output_keys=["error_code", "error_message"],
        )
        self._robot_name = robot_name
        self._grasp_distance = grasp_distance
        self._call = AbilityCall(self, PickCableAction, topic, timeout_s, done="picked")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            PickCableGoal(
                robot_name=self._robot_name,
                cable_id=userdata.cable_id,
                cable_end=userdata.cable_end,
                grasp_distance=self._grasp_distance,
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
