"""Decide what to do about a failure. Pure: the same failure and history give the same decision."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Container,
    ContainerKind,
    Param,
    State,
)
from remodel_tasks.core.task_charts.task_chart import marked, step_of
from remodel_tasks.core.use_case.fault import Do, Fault, Limits, Policy, Response


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
    Do.OTHER_END: "a new part with its other end first",
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


_INTEGERS = ("int", "uint")


@dataclass(frozen=True)
class Adjustable:
    """Whose parameters can be changed.

    Attributes:
        parameters: ability -> its goal's parameters by name, with their ROS types.
        nested: charts of the behaviors that tasks nest, by name.
    """

    parameters: Mapping[str, Mapping[str, str]]
    nested: Mapping[str, Chart]


def with_parameters(
    chart: Chart, state_path: str, values: Mapping[str, float], adjustable: Adjustable
) -> Chart:
    """Return a task's chart with other parameters of the node that has failed.

    A behavior nested there becomes a container with the same states, under the same names.

    Args:
        chart: of the task.
        state_path: of the state that failed.
        values: parameter -> value.
        adjustable: see Adjustable.
    """
    failed = step_of(state_path)
    nodes = tuple(
        _with_values(node, values, adjustable) if node.id == failed else node
        for node in chart.nodes
    )
    return marked(replace(chart, nodes=nodes))


def observing_from(chart: Chart, view: int, adjustable: Adjustable) -> Chart:
    """Return a task's chart in which everything is observed from another viewpoint.

    All observations change, not only those of the step that failed: a step often fails by what
    another one before it has seen. Behaviors that nest observations become containers.

    Args:
        chart: of the task.
        view: 0 the usual viewpoint, 1 and up others.
        adjustable: see Adjustable.
    """
    nodes = tuple(_with_values(node, {VIEW: view}, adjustable) for node in chart.nodes)
    return marked(replace(chart, nodes=nodes))


def _with_values(node: AnyNode, values: Mapping[str, float], adjustable: Adjustable) -> AnyNode:
    if isinstance(node, State):
        taken = adjustable.parameters.get(node.type.removesuffix("State"), {})
        new = tuple(
            Param(name, _literal(value, taken[name]))
            for name, value in values.items()
            if name in taken
        )
        kept = tuple(p for p in node.params if p.name not in {param.name for param in new})
        return replace(node, params=(*kept, *new))
    if isinstance(node, Behavior) and node.type in adjustable.nested:
        inner = adjustable.nested[node.type]
        nodes = tuple(_with_values(each, values, adjustable) for each in inner.nodes)
        if nodes == inner.nodes:
            return node
        body = replace(
            inner,
            name=node.id,
            description="",
            inputs=tuple(replace(each, default=None) for each in inner.inputs),
            nodes=nodes,
        )
        return Container(
            node.id,
            ContainerKind.SEQUENCE.value,
            node.transitions,
            attempts=node.attempts,
            timeout_s=node.timeout_s,
            on_error=node.on_error,
            body=body,
        )
    if isinstance(node, Container):
        inside = tuple(_with_values(each, values, adjustable) for each in node.body.nodes)
        return replace(node, body=replace(node.body, nodes=inside))
    return node


def _literal(value: float, ros_type: str) -> float:
    """Return a value as a field of a ROS type takes it: whole numbers where it takes no others."""
    return int(value) if ros_type.startswith(_INTEGERS) else value
