"""Decide what to do about a failure. Pure: the same failure and history give the same decision."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from remodel_planning.core.use_case.fault import Do, Response
from remodel_planning.core.use_case.policy import Limits, Policy
from remodel_supervision.core.recovery.failure import Failure, Spent

# Field of the goals of abilities that observe: 0 is the usual viewpoint, 1 and up are others.
VIEW = "view"


@dataclass(frozen=True)
class Decision:
    """What is done about a failure, and why.

    Attributes:
        failure: what it answers.
        do: what.
        change: parameter -> new value; with Do.RETRY_WITH, and with Do.LOOK_AGAIN the `view` from
            which the task's observations are made.
        because: the reason, one sentence for a person.
    """

    failure: Failure
    do: Do
    change: tuple[tuple[str, float], ...]
    because: str


def decide(
    failure: Failure,
    earlier: Sequence[tuple[str, Do]],
    spent: Spent,
    policy: Policy,
    possible: Collection[Do] = tuple(Do),
    unpromising: Collection[Do] = (),
    fruitless: Collection[Do] = (),
) -> Decision:
    """Return what to do about a failure.

    The responses to its fault are taken in order, each as often as stated; those that are not
    possible now, hardly ever help, or changed nothing of this failure before, are skipped: what
    repeats to the last figure is no chance. A task or run beyond its limits is ended,
    and so is a task for which an operator would be asked and none is there: nothing is tried again
    in place of an answer.

    Args:
        failure: what happened.
        earlier: what was done about this task's failures so far, each with its fault's name.
        spent: attempts and time so far, this failure's attempt included.
        policy: the use case's.
        possible: what can be done now; without an operator, asking is not.
        unpromising: what has hardly ever helped against this fault.
        fruitless: after what this task failed with the same figure as before.
    """
    reason = _run_is_over(spent, policy.limits)
    if reason:
        return Decision(failure, Do.STOP, (), reason)
    same = [do for fault, do in earlier if fault == failure.fault.name]
    responses = policy.responses_to(failure.fault)
    reason = _task_is_over(spent, policy.limits)
    if reason:
        last = responses[-1].do
        ending = last if last.is_lasting else policy.unattended_for(failure.fault)
        return _lasting(failure, ending, reason, policy, possible=possible)
    offered = [each.do for each in responses if each.do in possible]
    seldom = [do for do in offered if do in unpromising]
    vain = [do for do in offered if do in fruitless and do not in seldom]
    spared = {*seldom, *vain}
    without = f"; {_listed(seldom)} spared, which hardly ever helps" if seldom else ""
    without += f"; {_listed(vain)} spared, which led to the same figure again" if vain else ""
    for response in responses:
        done = same.count(response.do)
        if response.do.is_lasting:
            tried = f"{', '.join(_counted(same))} did not help" if same else "nothing else fits"
            return _lasting(failure, response.do, f"{tried}{without}", policy, possible=possible)
        if response.do in possible and response.do not in spared and done < response.times:
            change = _changed(response, failure, done)
            if response.do is Do.RETRY_WITH and not change:
                continue
            if response.do is Do.LOOK_AGAIN:
                change = ((VIEW, _views(earlier) + 1),)
            because = f"answer {done + 1} of {response.times} to {failure.fault.name}{without}"
            return Decision(failure, response.do, change, because)
    unattended = policy.unattended_for(failure.fault)
    return _lasting(failure, unattended, f"no response is left{without}", policy, possible=possible)


def _views(earlier: Sequence[tuple[str, Do]]) -> int:
    """Return how many viewpoints but the usual one a task was observed from."""
    return sum(do is Do.LOOK_AGAIN for _, do in earlier)


def _run_is_over(spent: Spent, limits: Limits) -> str:
    if spent.run_failures > limits.run_failures:
        return f"{spent.run_failures} failures in this run; at most {limits.run_failures}"
    if spent.run_s > limits.run_s:
        return f"the run takes {spent.run_s:.0f} s; at most {limits.run_s:.0f} s"
    return ""


def _task_is_over(spent: Spent, limits: Limits) -> str:
    if spent.task_attempts >= limits.task_attempts:
        return f"{spent.task_attempts} attempts at this task; at most {limits.task_attempts}"
    if spent.task_s > limits.task_s:
        return f"the task takes {spent.task_s:.0f} s; at most {limits.task_s:.0f} s"
    return ""


def _lasting(
    failure: Failure, do: Do, reason: str, policy: Policy, possible: Collection[Do]
) -> Decision:
    if do is Do.ASK_OPERATOR and do not in possible:
        unattended = policy.unattended_for(failure.fault)
        return Decision(failure, unattended, (), f"{reason}; no operator to ask")
    return Decision(failure, do, (), reason)


def _counted(done: Sequence[Do]) -> list[str]:
    return [f"{_listed([do])} x {count}" for do, count in Counter(done).items()]


def _listed(done: Sequence[Do]) -> str:
    return ", ".join(do.value.replace("_", " ") for do in done)


def _changed(response: Response, failure: Failure, done: int) -> tuple[tuple[str, float], ...]:
    """Return the new values of the parameters; without those at their bounds already."""
    values, bounds = dict(failure.parameters), dict(failure.bounds)
    changed = []
    for name, change in response.change:
        if name not in values:
            continue
        value = float(values[name])
        new = min(value + change.by, change.bound, bounds.get(name, change.bound))
        if new > value:
            changed.append((name, new))
    return tuple(changed)
