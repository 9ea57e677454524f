"""The state of DiscardCable, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import DiscardCableAction, DiscardCableGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class DiscardCableState(EventState):
    """Take a wire off the panel and drop it into the scrap bin; ends that are connected are released first.

    -- robot_name  string  Arm that does it, such as "robot_1".
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1"; empty: the wire that the hand holds.

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= discarded  [writes nothing] No piece of the wire is left in the cell.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, robot_name="robot_1", timeout_s=120.0, topic="remodel_abilities/discardcable"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["discarded", "failed", "command_error"],
            input_keys=["cable_id"],
            output_keys=["error_code", "error_message"],
        )
        self._robot_name = robot_name
        self._call = AbilityCall(self, DiscardCableAction, topic, timeout_s, done="discarded")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            DiscardCableGoal(
                robot_name=self._robot_name,
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
