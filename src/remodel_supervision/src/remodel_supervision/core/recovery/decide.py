"""Decide what to do about a failure. Pure: the same failure and history give the same decision."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
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
        because: the reason, a clause for a person, such as "it has failed once".
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
    offered = [r.do for r in responses if r.do in possible and not r.do.is_lasting]
    seldom = [do for do in offered if do in unpromising]
    vain = [do for do in offered if do in fruitless and do not in seldom]
    spared = {*seldom, *vain}
    without = f", and {_listed(seldom)} hardly ever helps" if seldom else ""
    without += f", and {_listed(vain)} led to the same figure again" if vain else ""
    for response in responses:
        done = same.count(response.do)
        if response.do.is_lasting:
            tried = (
                f"{counted_deeds(same)} did not help" if same else "nothing else fits this failure"
            )
            return _lasting(failure, response.do, f"{tried}{without}", policy, possible=possible)
        if response.do in possible and response.do not in spared and done < response.times:
            change = _changed(response, failure, done)
            if response.do is Do.RETRY_WITH and not change:
                continue
            if response.do is Do.LOOK_AGAIN:
                change = ((VIEW, _views(earlier) + 1),)
            what = failure.fault.name.replace("_", " ")
            because = f"that is what it does about '{what}'{_the_time(done + 1, response.times)}"
            because += without
            return Decision(failure, response.do, change, because)
    unattended = policy.unattended_for(failure.fault)
    return _lasting(
        failure, unattended, f"nothing else is left to try{without}", policy, possible=possible
    )


def counted_deeds(done: Sequence[Do]) -> str:
    """Return what was done, for a person: "trying again twice and a new part once"."""
    times = Counter(done).items()
    return _joined(f"{_DEEDS[do]} {_TIMES.get(n, f'{n} times')}" for do, n in times)


def _views(earlier: Sequence[tuple[str, Do]]) -> int:
    """Return how many viewpoints but the usual one a task was observed from."""
    return sum(do is Do.LOOK_AGAIN for _, do in earlier)


def _run_is_over(spent: Spent, limits: Limits) -> str:
    if spent.run_failures > limits.run_failures:
        return f"the run has failed {spent.run_failures} times; it may {limits.run_failures} times"
    if spent.run_s > limits.run_s:
        return f"the run has taken {spent.run_s:.0f} s of the {limits.run_s:.0f} s that it may take"
    return ""


def _task_is_over(spent: Spent, limits: Limits) -> str:
    if spent.task_attempts >= limits.task_attempts:
        return f"the task has had {spent.task_attempts} of its {limits.task_attempts} attempts"
    if spent.task_s > limits.task_s:
        return (
            f"the task has taken {spent.task_s:.0f} s of the {limits.task_s:.0f} s that it may take"
        )
    return ""


def _lasting(
    failure: Failure, do: Do, reason: str, policy: Policy, possible: Collection[Do]
) -> Decision:
    if do is Do.ASK_OPERATOR and do not in possible:
        unattended = policy.unattended_for(failure.fault)
        return Decision(failure, unattended, (), f"{reason}, and there is no operator to ask")
    return Decision(failure, do, (), reason)


_DEEDS = {
    Do.RETRY: "trying again",
    Do.RETRY_WITH: "trying with changed parameters",
    Do.LOOK_AGAIN: "looking from another view",
    Do.OTHER_METHOD: "another method",
    Do.NEW_PART: "a new part",
    Do.REPLAN: "doing the task later",
    Do.SET_ASIDE: "skipping the task",
    Do.ASK_OPERATOR: "asking an operator",
    Do.STOP: "stopping",
}
_TIMES = {1: "once", 2: "twice"}
_PLACES = {1: "first", 2: "second", 3: "third"}


def _listed(done: Sequence[Do]) -> str:
    return _joined(_DEEDS[do] for do in done)


def _joined(parts: Iterable[str]) -> str:
    *first, last = parts
    return f"{', '.join(first)} and {last}" if first else last


def _the_time(number: int, times: int) -> str:
    """Return how often it does so, and which time this is; empty of what it does once."""
    place = _PLACES.get(number, f"{number}th")
    return f", up to {times} times; this is the {place}" if times > 1 else ""


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
