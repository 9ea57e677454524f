"""Place a pin with two robots, as D5.1, 3.2 writes the state."""

from remodel_msgs.msg import PlacePinAction, PlacePinGoal

from flexbe_core import EventState
from remodel_states.ability_call import AbilityCall

NORMAL = "PlacePin finished normally"
SLOW = "PlacePin takes longer than normal"


class PlacePinState(EventState):
    """Place a pin with two robots.

    -- max_time  float  [s] Longest normal duration.
    -- robot_1_name  string  First arm.
    -- robot_2_name  string  Second arm.
    -- path_space  float  [m] Between the poses of the path.
    -- connector_space  float  [m] Between neighbouring connectors.
    -- centered  bool  True centers all poses.
    -- rotate  bool  True puts the long axis in Y.
    -- show_in_TF  bool  True broadcasts the poses as TF frames.
    -- timeout_s  float  [s] ROS time that the ability gets [grace 2 s].
    -- topic  string  Action topic of the ability server.

    ># placepin_id  string  Identifier for traceability.

    #> elapsed_time  float  [s] That the ability took.
    #> error_code  int  Code of a failure (remodel_msgs/ErrorCode).
    #> error_message  string  What failed and what to do.

    <= PlacePin finished normally  [writes elapsed_time] The pin is placed, within max_time.
    <= PlacePin takes longer than normal  The pin is placed, but it took longer.
        [writes elapsed_time]
    <= failed  [writes error_code, error_message] The ability failed; error_code says why.
    <= command_error  [writes error_code, error_message] Refused, or the server is not there.

    """

    def __init__(self, max_time=30.0, robot_1_name="robot_1", robot_2_name="robot_2", path_space=0.01, connector_space=0.02, centered=False, rotate=False, show_in_TF=False, timeout_s=60.0, topic="remodel_abilities/placepin"):  # fmt: skip
        """Connect to the ability server."""
        super().__init__(
            outcomes=[
                "PlacePin finished normally",
                "PlacePin takes longer than normal",
                "failed",
                "command_error",
            ],
            input_keys=["placepin_id"],
            output_keys=["elapsed_time", "error_code", "error_message"],
        )
        self._max_time = max_time
        self._parameters = {
            "robot_1_name": robot_1_name,
            "robot_2_name": robot_2_name,
            "path_space": path_space,
            "connector_space": connector_space,
            "centered": centered,
            "rotate": rotate,
            "show_in_TF": show_in_TF,
        }
        self._call = AbilityCall(self, PlacePinAction, topic, timeout_s, done=NORMAL)

    def on_enter(self, userdata):
        """Send the goal."""
        self._call.start(PlacePinGoal(id=userdata.placepin_id, **self._parameters))

    def execute(self, userdata):
        """Return the outcome once the ability has ended."""
        outcome = self._call.outcome()
        if outcome is not None:
            self._call.write_errors(userdata)
        if outcome != NORMAL:
            return outcome
        userdata.elapsed_time = self._call.result.elapsed_time
        return SLOW if self._call.result.elapsed_time > self._max_time else NORMAL

    def on_exit(self, userdata):
        """Cancel what still runs."""
        self._call.finish()

    def on_stop(self):
        """Cancel what still runs, on an engine that skips on_exit on preempt."""
        self._call.finish()
