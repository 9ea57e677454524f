"""The state of LocateGearboxComponent, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import LocateGearboxComponentAction, LocateGearboxComponentGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall
from remodel_states.parameters import checked_byte


class LocateGearboxComponentState(EventState):
    """Find a component on the panel, and one of its terminals, by camera.

    -- view  int  From where it is observed: 0 the usual viewpoint, 1 and up others (modulo the viewpoints of the cell).
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># component_id  string  Component on the loaded panel, such as "Q1".
    ># terminal_id  string  Terminal of that component; empty: the component only.

    #> component_pose  geometry_msgs/PoseStamped  Centre of the component's base, world frame [m].
    #> socket_pose  geometry_msgs/PoseStamped  Centre of the terminal's opening, x axis points into the terminal, world frame [m]; unset without terminal_id.
    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= located  [writes component_pose, socket_pose] The component was seen.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, view=0, timeout_s=30.0, topic="remodel_abilities/locategearboxcomponent"):
        """Connect to the ability server."""
        super().__init__(
            outcomes=["located", "failed", "command_error"],
            input_keys=["component_id", "terminal_id"],
            output_keys=["component_pose", "socket_pose", "error_code", "error_message"],
        )
        self._view = checked_byte("view", view)
        self._call = AbilityCall(
            self, LocateGearboxComponentAction, topic, timeout_s, done="located"
        )

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            LocateGearboxComponentGoal(
                component_id=userdata.component_id,
                terminal_id=userdata.terminal_id,
                view=self._view,
            )
        )

    def execute(self, userdata):
        """Return the outcome once the ability has ended."""
        outcome = self._call.outcome()
        if outcome is not None:
            self._call.write_errors(userdata)
        if outcome == "located":
            userdata.component_pose = self._call.result.component_pose
            userdata.socket_pose = self._call.result.socket_pose
        return outcome

    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
