"""The state of DetectCable, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import DetectCableAction, DetectCableGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall
from remodel_states.parameters import checked_byte


class DetectCableState(EventState):
    """Find a wire and its loose ends by camera.

    -- view  int  From where it is observed: 0 the usual viewpoint, 1 and up others (modulo the viewpoints of the cell).
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire that the feeder presented, such as "W1".

    #> observation  remodel_msgs/CableObservation  World frame; meaningful only when success.
    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= detected  [writes observation] The wire was seen.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, view=0, timeout_s=30.0, topic="remodel_abilities/detectcable"):
        """Connect to the ability server."""
        super().__init__(
            outcomes=["detected", "failed", "command_error"],
            input_keys=["cable_id"],
            output_keys=["observation", "error_code", "error_message"],
        )
        self._view = checked_byte("view", view)
        self._call = AbilityCall(self, DetectCableAction, topic, timeout_s, done="detected")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            DetectCableGoal(
                cable_id=userdata.cable_id,
                view=self._view,
            )
        )

    def execute(self, userdata):
        """Return the outcome once the ability has ended."""
        outcome = self._call.outcome()
        if outcome is not None:
            self._call.write_errors(userdata)
        if outcome == "detected":
            userdata.observation = self._call.result.observation
        return outcome

    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
