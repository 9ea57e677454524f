"""The state of PlaceConnector, generated from config/abilities.yaml: change that."""

from remodel_msgs.msg import PlaceConnectorAction, PlaceConnectorGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall


class PlaceConnectorState(EventState):
    """Push a connector with several pins into its header until it latches, test it by a pull, and release it.

    -- connector_id  string  Connector at the end of the cable, such as "P1".
    -- robot_name  string  Arm that does it, such as "robot_1".
    -- force_limit  float  [N] > 0: axial force at which the push stops.
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># cable_id  string  Wire of the loaded panel, such as "W1".
    ># component_id  string  Component of the loaded panel, such as "Q1".
    ># terminal_id  string  Header of that component.
    ># socket_pose  geometry_msgs/PoseStamped  As LocateGearboxComponent returns it; frame "world" or "panel" [m].

    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= placed  [writes nothing] The connector is mated.
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, connector_id, robot_name="robot_1", force_limit=30.0, timeout_s=60.0, topic="remodel_abilities/placeconnector"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=["placed", "failed", "command_error"],
            input_keys=["cable_id", "component_id", "terminal_id", "socket_pose"],
            output_keys=["error_code", "error_message"],
        )
        self._connector_id = connector_id
        self._robot_name = robot_name
        self._force_limit = force_limit
        self._call = AbilityCall(self, PlaceConnectorAction, topic, timeout_s, done="placed")

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(
            PlaceConnectorGoal(
                robot_name=self._robot_name,
                connector_id=self._connector_id,
                cable_id=userdata.cable_id,
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
        return outcome

    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
