"""Ask the operator for a value."""

import ast

from flexbe_msgs.msg import BehaviorInputAction, BehaviorInputGoal, BehaviorInputResult

from flexbe_core import EventState, Logger
from flexbe_core.proxy import ProxyActionClient

ACTION = "flexbe/behavior_input"


class InputState(EventState):
    """Ask the operator for a value, see flexbe_input.

    -- request  uint8   Kind of value, as a number that the operator's interface defines.
    -- message  string  Question to show to the operator.

    #> data  object  The value, read from the text of a literal; None if there is none.

    <= received       The operator entered a value.
    <= aborted        The operator entered no value.
    <= no_connection  No node answers questions: flexbe_input is not running, or stopped.
    <= data_error     The operator's text is not a literal.

    """

    def __init__(self, request, message):
        super().__init__(
            outcomes=["received", "aborted", "no_connection", "data_error"], output_keys=["data"]
        )
        self._request = request
        self._message = message
        self._client = ProxyActionClient({ACTION: BehaviorInputAction}, wait_duration=1)
        self._is_asked = False
        self._outcome = None

    def on_enter(self, userdata):
        """Ask."""
        self._outcome = None
        try:
            goal = BehaviorInputGoal(request_type=self._request, msg=self._message)
            self._client.send_goal(ACTION, goal)
            self._is_asked = True
        except ValueError as error:
            Logger.logwarn("%s: %s", self.name, error)
            self._is_asked = False

    def execute(self, userdata):
        """Read the answer, once there is one."""
        if self._outcome is None:
            self._outcome = self._answer(userdata)
        return self._outcome

    def on_exit(self, userdata):
        """Withdraw a question that is not answered."""
        self._client.cancel(ACTION)

    def _answer(self, userdata):
        """Write the answer to userdata; return the outcome, None without an answer."""
        if self._is_asked and not self._client.has_result(ACTION):
            if self._client.is_available(ACTION):
                return None
            self._is_asked = False
        userdata.data = None
        if not self._is_asked:
            return "no_connection"
        result = self._client.get_result(ACTION)
        if result.result_code != BehaviorInputResult.RESULT_OK:
            return "aborted"
        try:
            userdata.data = ast.literal_eval(result.data)
        except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError) as error:
            Logger.logwarn("%s: cannot read the answer %.80r: %s", self.name, result.data, error)
            return "data_error"
        return "received"
