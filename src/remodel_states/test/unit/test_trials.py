"""When the conformance kit cancels a goal."""

from remodel_msgs.msg import PlaceCableGoal, PlaceCableResult

from remodel_states.conformance.clauses import CANCEL
from remodel_states.conformance.rules import Exchange, Result
from remodel_states.conformance.trial import Trials

BEGINS_AT_S = 1.0


class SlowMachine:
    """Where goals reach the server late, and cancels at once: those have a connection of their own.

    As actionlib does, it ends a goal that was cancelled before it arrived with an empty result.
    """

    def __init__(self):
        self.now_s = 0.0

    def send(self, goal):
        self.sent_s = self.now_s
        self.exchange = Exchange(goal, self.now_s)
        return self.exchange

    def cancel(self, exchange):
        is_late = self.now_s < self.sent_s + BEGINS_AT_S
        result = PlaceCableResult()
        if not is_late:
            result = PlaceCableResult(id=exchange.goal.id, error_code=2, error_message="cancelled")
            result.elapsed_time = self.now_s - self.sent_s
        exchange.cancelled_wall_s = self.now_s
        exchange.results.append(Result(self.now_s, self.now_s, 2, "", result))

    def wait(self, condition, limit_s):
        end = self.now_s + limit_s
        while not condition() and self.now_s < end:
            self.now_s += 0.1
            if self.now_s >= self.sent_s + BEGINS_AT_S:
                self.exchange.active_ros_s = self.now_s
        return condition()


def test_a_goal_is_cancelled_only_when_the_server_works_on_it():
    trials = Trials(SlowMachine(), PlaceCableGoal(id="good", timeout=3.0), {0, 2})
    trials._nominal_s = 0.6
    trial = trials._cancel()
    assert (trial.name, trial.faults, trial.unjudged) == (CANCEL.name, (), "")
