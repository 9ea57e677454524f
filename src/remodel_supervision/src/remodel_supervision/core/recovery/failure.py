"""One failure of a task, with all that its supervisor gathered about it."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_planning.core.use_case.fault import Fault


@dataclass(frozen=True)
class Failure:
    """A task's behavior ended without success.

    Attributes:
        task: name of the task, such as "W1".
        fault: what it was.
        code: remodel_msgs/ErrorCode of the operation that decided it; 0 if no operation failed.
        ability: of that operation; empty without one.
        state_path: of the state that asked for it; empty without one.
        text: what the ability, or the engine, said.
        at_s: [s] ROS time.
        parameters: of the operation's goal and, where it has none of that name, of those before it
            in the same step of the task: name -> value, as text.
        bounds: parameter -> what it must not exceed here, whatever the policy allows.
        evidence: where to look it up: pictures and records, by name.
    """

    task: str
    fault: Fault
    code: int
    ability: str
    state_path: str
    text: str
    at_s: float
    parameters: tuple[tuple[str, str], ...] = ()
    bounds: tuple[tuple[str, float], ...] = ()
    evidence: tuple[str, ...] = ()


@dataclass(frozen=True)
class Spent:
    """What a task, and the run that it belongs to, have spent so far.

    Attributes:
        task_attempts: how often the task was begun.
        task_s: [s] ROS time that these took.
        run_failures: failures of all tasks of the run.
        run_s: [s] ROS time since the run began.
    """

    task_attempts: int
    task_s: float
    run_failures: int
    run_s: float
