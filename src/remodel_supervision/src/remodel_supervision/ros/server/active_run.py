"""A run under way, and what the client of its goal is answered."""

from __future__ import annotations

from dataclasses import dataclass

import actionlib
import rospy
from remodel_msgs.msg import ErrorCode, RunUseCaseFeedback, RunUseCaseGoal, RunUseCaseResult

from remodel_run.progress import sums_words
from remodel_supervision.core.runs.events import Ending
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.core.runs.sums import sums_of
from remodel_supervision.ros.server.run_messages import RunView, levels
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor


@dataclass
class ActiveRun:
    """A run under way.

    Attributes:
        handle: the goal that asked for it; None if it was resumed.
        begun: ROS time at which this process began or resumed it.
    """

    supervisor: UseCaseSupervisor
    handle: actionlib.ServerGoalHandle | None
    begun: rospy.Time

    def feed_back(self, view: RunView) -> None:
        """Publish feedback of the goal, if it came from one."""
        state = self.supervisor.state
        if self.handle is None or state.ended is not None:
            return
        ended = len(state.in_stage(Stage.DONE, Stage.SET_ASIDE))
        self.handle.publish_feedback(
            RunUseCaseFeedback(
                id=self.handle.get_goal().id,
                message=self.supervisor.doing,
                elapsed_time=(rospy.Time.now() - self.begun).to_sec(),
                completed_percentage=100.0 * ended / max(1, len(state.tasks)),
                task=state.current,
                levels=levels(view),
            )
        )

    def answer(self, state: RunState) -> None:
        """End the goal, if it came from one, as the run has ended."""
        if self.handle is None:
            return
        result = self._result()
        because = state.ended.because if state.ended else ""
        result.success = state.ended is not None and state.ended.ending is Ending.COMPLETE
        if result.success:
            self.handle.set_succeeded(result)
            return
        result.error_code, result.error_message = ErrorCode.INTERNAL, because
        if state.ended is not None and state.ended.ending is Ending.STOPPED:
            result.error_code = ErrorCode.PREEMPTED
            self.handle.set_canceled(result, because)
        else:
            self.handle.set_aborted(result, because)

    def abort(self, because: str) -> None:
        """End the goal, if it came from one, since this supervisor gives the run up."""
        if self.handle is None:
            return
        result = self._result()
        result.error_code, result.error_message = ErrorCode.STALE_OWNER, because
        self.handle.set_aborted(result, because)

    def _result(self) -> RunUseCaseResult:
        assert self.handle is not None, "only called with a goal"
        state = self.supervisor.state
        done = list(state.in_stage(Stage.DONE))
        return RunUseCaseResult(
            id=self.handle.get_goal().id,
            message=sums_words(sums_of(state)),
            elapsed_time=(rospy.Time.now() - self.begun).to_sec(),
            run=self.supervisor.run,
            done=done,
            left=[name for name in state.tasks if name not in done],
        )


def refusal(goal: RunUseCaseGoal, code: int, text: str) -> RunUseCaseResult:
    """Return the result of a goal that is rejected."""
    return RunUseCaseResult(id=goal.id, success=False, error_code=code, error_message=text)
