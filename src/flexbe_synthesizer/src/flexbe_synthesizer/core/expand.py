"""Expand a checked chart into a plain FlexBE behavior.

`ext:attempts` on X puts a counting state `X_attempts` before X: all that leads to X leads there,
and its count lives in the root's userdata, where it starts at 0 in every run. `ext:timeout_s` on
an X that does not keep time itself makes X a concurrency container of `run`, which is X, and
`timer`, a state that waits.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.data_flow import DataFlow, Key, ports
from flexbe_synthesizer.core.machine import (
    BehaviorUse,
    Child,
    Condition,
    Container,
    Exit,
    Kind,
    Machine,
    Pair,
    StateUse,
)
from flexbe_synthesizer.core.model import Chart
from flexbe_synthesizer.core.resolve import (
    EXHAUSTED,
    TIMED_OUT,
    ResolvedChart,
    ResolvedNode,
    arguments,
)
from flexbe_synthesizer.core.signature import BehaviorClass, StateClass

_RUN, _TIMER = "run", "timer"
_COUNTED = "counted"


def counter_label(node_id: str) -> str:
    """Return the label of the state that counts the attempts of another."""
    return f"{node_id}_attempts"


def added_labels(entry: ResolvedNode) -> Iterator[str]:
    """Yield the labels that the expansion of a node takes from the chart's ids.

    The FlexBE App joins the parts of a path with `_`, so what lies inside a container takes one.
    """
    if entry.node.attempts is not None:
        yield counter_label(entry.node.id)
    if entry.is_timed:
        yield f"{entry.node.id}_{_RUN}"
        yield f"{entry.node.id}_{_TIMER}"


def chart_steps(chart: Chart, taken: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Return what an engine reports, as steps of the chart.

    Args:
        chart: the chart of the behavior that ran.
        taken: (path of the state, outcome), such as `("/Locate_attempts", "counted")`, in order.

    Returns:
        (id, event) of each state or behavior of the chart that was left.
    """
    counters = {counter_label(n.id): n.id for n in chart.nodes if n.attempts is not None}
    ids = {node.id for node in chart.nodes}
    steps = []
    for path, outcome in taken:
        label, _, inner = path.strip("/").partition("/")
        if label in counters and outcome == EXHAUSTED:
            steps.append((counters[label], outcome))
        elif label in ids and inner in ("", _RUN):
            steps.append((label, outcome))
    return tuple(steps)


def expand(resolved: ResolvedChart, flow: DataFlow, package: str) -> Machine:
    """Return the behavior that a chart without errors becomes."""
    chart = resolved.chart
    expansion = _Expansion(resolved, flow)
    entries = sorted(resolved.nodes, key=lambda entry: entry.node.id != chart.initial)
    children = tuple(child for entry in entries for child in expansion.children(entry))
    inputs = tuple(port.name for port in chart.inputs)
    outputs = tuple(port.name for port in chart.outputs)
    defaults = {port.name: port.default for port in chart.inputs}
    userdata = [Pair(key, defaults.get(key)) for key in dict.fromkeys((*inputs, *outputs))]
    userdata += [Pair(key, 0) for key in expansion.counts.values()]
    root = Container(
        Kind.STATE_MACHINE,
        tuple(outcome.name for outcome in chart.outcomes),
        inputs,
        outputs,
        children,
        tuple(userdata),
    )
    description = chart.description or f"The state chart {chart.name}."
    return Machine(chart.name, package, description, root)


class _Expansion:
    """The children that the nodes of one chart become."""

    def __init__(self, resolved: ResolvedChart, flow: DataFlow) -> None:
        self._resolved = resolved
        self._flow = flow
        taken = {*flow.inputs.values(), *flow.outputs.values()}
        taken |= {port.name for port in resolved.chart.inputs}
        taken |= {port.name for port in resolved.chart.outputs}
        self.counts: dict[str, str] = {}
        for entry in resolved.nodes:
            if entry.node.attempts is not None:
                wanted = f"{names.snake_case(entry.node.id)}_attempts"
                self.counts[entry.node.id] = names.take_unused(wanted, taken)
                taken.add(self.counts[entry.node.id])

    def children(self, entry: ResolvedNode) -> Iterator[Child]:
        """Yield what a node becomes: its counter, if it has one, and itself."""
        node = entry.node
        exits = {
            t.event: Exit(t.event, self._entry(t.target), t.autonomy) for t in node.transitions
        }
        if node.attempts is not None and self._resolved.counter is not None:
            yield Child(
                counter_label(node.id),
                _use(self._resolved.counter, attempts=node.attempts),
                (Exit(_COUNTED, node.id), exits[EXHAUSTED]),
                (("attempt", self.counts[node.id]),),
            )
        own = tuple(exits[e] for e in _own_outcomes(entry))
        if entry.is_timed and self._resolved.timer is not None:
            yield self._timed(entry, self._resolved.timer, own, exits[TIMED_OUT])
        else:
            yield Child(node.id, self._content(entry), own, self._remapping(entry))

    def _entry(self, target: str) -> str:
        """Return the label that a transition to a target leads to."""
        return counter_label(target) if target in self.counts else target

    def _timed(
        self, entry: ResolvedNode, timer: StateClass, own: tuple[Exit, ...], timed_out: Exit
    ) -> Child:
        """Return the container of a node and its timer.

        The autonomy of a transition stands at the child, where the engine keeps to it.
        """
        remapping = self._remapping(entry)
        conditions = [Condition(exit_.outcome, _RUN, exit_.outcome) for exit_ in own]
        conditions.append(Condition(TIMED_OUT, _TIMER, "done"))
        inputs, outputs = ports(entry)
        defaulted = {key.name for key in self._flow.defaulted if key.node == entry.node.id}
        keys = tuple((key, key) for key, _home in remapping)
        container = Container(
            Kind.CONCURRENCY,
            tuple(dict.fromkeys(condition.outcome for condition in conditions)),
            tuple(port.name for port in inputs if port.name not in defaulted),
            tuple(port.name for port in outputs),
            (
                Child(
                    _RUN,
                    self._content(entry),
                    tuple(Exit(e.outcome, e.outcome, e.autonomy) for e in own),
                    keys,
                ),
                Child(
                    _TIMER,
                    _use(timer, wait_time=entry.node.timeout_s),
                    (Exit("done", TIMED_OUT, timed_out.autonomy),),
                ),
            ),
            conditions=tuple(conditions),
        )
        leaving = {exit_.outcome: exit_.target for exit_ in (*own, timed_out)}
        exits = tuple(Exit(outcome, leaving[outcome]) for outcome in container.outcomes)
        return Child(entry.node.id, container, exits, remapping)

    def _content(self, entry: ResolvedNode) -> StateUse | BehaviorUse:
        """Return the state or behavior that a node is."""
        declaration = entry.declaration
        given = tuple(Pair(*item) for item in arguments(entry.node, entry.is_timed).items())
        if isinstance(declaration, BehaviorClass):
            defaulted = (p.name for p in declaration.inputs)
            kept = tuple(k for k in defaulted if Key(entry.node.id, k) in self._flow.defaulted)
            return BehaviorUse(declaration, given, kept)
        if declaration is None:
            raise AssertionError(f"{entry.node.id} was expanded though its class is not known")
        return StateUse(declaration, _alias(declaration, entry.is_qualified), given)

    def _remapping(self, entry: ResolvedNode) -> tuple[tuple[str, str], ...]:
        """Return the home of each key, inputs first."""
        inputs, outputs = ports(entry)
        homes: dict[str, str] = {}
        for port in inputs:
            if (key := Key(entry.node.id, port.name)) in self._flow.inputs:
                homes[port.name] = self._flow.inputs[key]
        for port in outputs:
            homes.setdefault(port.name, self._flow.outputs[Key(entry.node.id, port.name)])
        return tuple(homes.items())


def _own_outcomes(entry: ResolvedNode) -> tuple[str, ...]:
    """Return the outcomes that the node itself can have, whatever is added around it."""
    return (entry.signature.outcomes if entry.signature else None) or ()


def _use(state: StateClass, **values: float | None) -> StateUse:
    """Return a state that an extension adds."""
    return StateUse(state, state.name, tuple(Pair(*item) for item in values.items()))


def _alias(state: StateClass, is_qualified: bool) -> str:
    """Return the name that a state class is imported under; the FlexBE App reads both forms."""
    return f"{state.package}__{state.name}" if is_qualified else state.name
