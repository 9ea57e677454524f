"""What a task has gone through so far, and the failure that an execution of it ended with."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from remodel_planner.core.recovery.decide import Decision, decide
from remodel_planner.core.recovery.failure import Failure, Spent
from remodel_planner.core.recovery.fault import Do, FaultTable
from remodel_planner.core.recovery.policy import Policy
from remodel_planner.core.run import Execution
from remodel_planner.errors import UseCaseError

# Of a task that failed though no ability told of an error: remodel_msgs/ErrorCode.INTERNAL.
_UNTOLD = 5


@dataclass
class TaskHistory:
    """One task's failures and what was decided about them, the latest last."""

    codes: list[int] = field(default_factory=list)
    decisions: list[Decision] = field(default_factory=list)
    attempts: int = 0
    cell_s: float = 0.0


class Recovery:
    """Decides what to do about the failures of a run's tasks, by their histories."""

    def __init__(self, faults: FaultTable, policy: Policy) -> None:
        """Begin a run.

        Raises:
            UseCaseError: if the policy answers to a fault that there is not.
        """
        unknown = sorted(set(policy.responses) - set(faults.names))
        if unknown:
            raise UseCaseError(
                f"recovery.responses.{unknown[0]}: there is no such fault; there are "
                f"{', '.join(faults.names)}"
            )
        self._faults = faults
        self._policy = policy
        self._histories: dict[str, TaskHistory] = {}
        self._failures = 0
        self._run_s = 0.0

    def attempts(self, task: str) -> int:
        """Return how often a task has been executed."""
        return self._history(task).attempts

    def ended(self, execution: Execution) -> None:
        """Take in an execution about which nothing is to be decided."""
        self._take(execution)

    def decide(self, execution: Execution, possible: Collection[Do]) -> Decision:
        """Return what to do about an execution that did not do its task.

        Args:
            execution: how it went.
            possible: what can be done now.
        """
        history = self._take(execution)
        self._failures += 1
        failure = self._failure(execution, history)
        spent = Spent(history.attempts, history.cell_s, self._failures, self._run_s)
        decision = decide(failure, history.decisions, spent, self._policy, possible)
        history.decisions.append(decision)
        return decision

    def _take(self, execution: Execution) -> TaskHistory:
        history = self._history(execution.wire)
        history.attempts += 1
        history.cell_s += execution.cell_s
        self._run_s += execution.cell_s
        return history

    def _failure(self, execution: Execution, history: TaskHistory) -> Failure:
        """Return the failure of the execution's last operation that failed."""
        last = execution.failures[-1] if execution.failures else None
        code = last.error_code if last else _UNTOLD
        history.codes.append(code)
        fault = self._faults.diagnose(history.codes) or self._faults.of(_UNTOLD)
        return Failure(
            execution.wire,
            fault,
            code,
            last.ability if last else "",
            last.state_path if last else "",
            last.text if last else f"the behavior ended {execution.outcome}",
            execution.ended_s,
        )

    def _history(self, task: str) -> TaskHistory:
        return self._histories.setdefault(task, TaskHistory())
