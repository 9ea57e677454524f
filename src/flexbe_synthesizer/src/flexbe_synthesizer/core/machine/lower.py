"""Lower a checked chart to a plain FlexBE behavior, and label the states that this adds.

`ext:attempts` on X puts a counting state `X_attempts` before X: all that leads to X leads there,
and its count lives in the root's userdata, where it starts at 0 in every run; containers around X
pass it through. `ext:timeout_s` on an X that does not keep time itself makes X a concurrency
container of `run`, which is X, and `timer`, a state that waits. `ext:on_error` on X puts a deciding
state `X_error` behind the outcome `failed` of X.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.error_routes import codes_of_routes, route_event
from flexbe_synthesizer.core.chart.model import Chart, Container, ContainerKind
from flexbe_synthesizer.core.chart.names import ERROR_CODE, EXHAUSTED, FAILED, TIMED_OUT
from flexbe_synthesizer.core.library.data_flow import DataFlow, Support
from flexbe_synthesizer.core.library.resolve import (
    ResolvedChart,
    ResolvedNode,
    given_values,
    scopes,
)
from flexbe_synthesizer.core.library.signature import BehaviorClass, StateClass
from flexbe_synthesizer.core.machine import machine
from flexbe_synthesizer.core.machine.machine import (
    PREDICATES,
    BehaviorUse,
    Child,
    Condition,
    Exit,
    Kind,
    Machine,
    Pair,
    StateUse,
    Value,
    choose_by_code,
)

OTHER = "other"  # outcome of a chooser for the codes that no route names
RUN, TIMER = "run", "timer"  # what a container for a timeout holds


def counter_label(node_id: str) -> str:
    """Return the label of the state that counts the attempts of another."""
    return f"{node_id}_attempts"


def chooser_label(node_id: str) -> str:
    """Return the label of the state that parts the failures of another by code."""
    return f"{node_id}_error"


def added_labels(entry: ResolvedNode) -> Iterator[str]:
    """Yield the labels that the states added for a node take from the chart's ids.

    The FlexBE App joins the parts of a path with `_`, so what lies inside a container takes one.
    """
    if entry.node.attempts is not None:
        yield counter_label(entry.node.id)
    if entry.node.on_error:
        yield chooser_label(entry.node.id)
    if entry.use.is_timed:
        yield f"{entry.node.id}_{RUN}"
        yield f"{entry.node.id}_{TIMER}"


def chart_steps(chart: Chart, taken: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Return what an engine reports, as steps of the chart.

    Args:
        chart: the chart of the behavior that ran.
        taken: (path of the state, outcome), such as `("/Locate_attempts", "counted")`, in order.

    Returns:
        (id, event) of each node of the chart that was left; the id of one inside containers has
        theirs before it, `Place/Insert`.
    """
    names_by_path = _StepNames(chart)
    steps = []
    for path, outcome in taken:
        if path in names_by_path.counters and outcome == EXHAUSTED:
            steps.append((names_by_path.counters[path], outcome))
        elif path in names_by_path.choosers:
            event = FAILED if outcome == OTHER else outcome
            steps.append((names_by_path.choosers[path], event))
        elif path in names_by_path.nodes and (path, outcome) not in names_by_path.parted:
            steps.append((names_by_path.nodes[path], outcome))
    return tuple(steps)


class _StepNames:
    """What the states of a lowered chart are in the chart, by path."""

    def __init__(self, chart: Chart) -> None:
        self.nodes: dict[str, str] = {}
        self.counters: dict[str, str] = {}
        self.choosers: dict[str, str] = {}
        self.parted: set[tuple[str, str]] = set()  # steps that a chooser describes in more detail
        self._add(chart, "", "")

    def _add(self, chart: Chart, above: str, prefix: str) -> None:
        for node in chart.nodes:
            path, name = f"{above}/{node.id}", f"{prefix}{node.id}"
            self.nodes |= {path: name, f"{path}/{RUN}": name}
            if node.attempts is not None:
                self.counters[f"{above}/{counter_label(node.id)}"] = name
            if node.on_error:
                self.choosers[f"{above}/{chooser_label(node.id)}"] = name
                self.parted |= {(path, FAILED), (f"{path}/{RUN}", FAILED)}
            if isinstance(node, Container):
                inside = path if node.timeout_s is None else f"{path}/{RUN}"
                self._add(node.body, inside, f"{name}/")


_KINDS = {
    ContainerKind.SEQUENCE: Kind.STATE_MACHINE,
    ContainerKind.CONCURRENCY: Kind.CONCURRENCY,
    ContainerKind.PRIORITY: Kind.PRIORITY,
}
_COUNTED = "counted"
_NONE: Mapping[str, str] = MappingProxyType({})


def lower(resolved: ResolvedChart, package: str) -> Machine:
    """Return the behavior that a chart without errors becomes."""
    chart = resolved.chart
    counts = _count_keys(resolved)
    flow = resolved.flow
    defaults = {port.name: port.default for port in chart.inputs}
    inputs = tuple(port.name for port in chart.inputs)
    outputs = tuple(port.name for port in chart.outputs)
    userdata = [Pair(key, defaults.get(key)) for key in dict.fromkeys((*inputs, *outputs))]
    userdata += [Pair(key, 0) for key in counts.values()]
    root = machine.Container(
        Kind.STATE_MACHINE,
        tuple(outcome.name for outcome in chart.outcomes),
        input_keys=inputs,
        output_keys=outputs,
        children=_Lowering(resolved, flow, "", counts).children(),
        userdata=tuple(userdata),
    )
    is_visible = any(c.isprintable() and not c.isspace() for c in chart.description)
    description = chart.description if is_visible else f"The state chart {chart.name}."
    return Machine(chart.name, package, description, root, chart.author, chart.tags)


def _count_keys(resolved: ResolvedChart) -> Mapping[str, str]:
    """Return the userdata key of each count, by the path of the node that it counts."""
    taken: set[str] = set()
    for scope in scopes(resolved):
        flow = scope.flow
        taken |= flow.read.union(*(homes.values() for homes in flow.outputs.values()))
        taken |= {port.name for port in scope.chart.inputs}
        taken |= {port.name for port in scope.chart.outputs}
    counts = {}
    for path in sorted(_counted_paths(resolved, "")):  # whatever order the nodes stand in
        wanted = "_".join((*map(names.snake_case, path.split("/")), "attempts"))
        counts[path] = names.take_unused(wanted, taken)
        taken.add(counts[path])
    return counts


def _counted_paths(resolved: ResolvedChart, above: str) -> Iterator[str]:
    for entry in resolved.nodes:
        path = f"{above}{entry.node.id}"
        if entry.node.attempts is not None:
            yield path
        if entry.body is not None:
            yield from _counted_paths(entry.body, f"{path}/")


class _Lowering:
    """The children that the nodes of a chart or container become.

    Attributes:
        above: path of the container, with a slash at its end; empty for the chart itself.
        counts: userdata keys of all counts of the chart, by path.
    """

    def __init__(
        self, resolved: ResolvedChart, flow: DataFlow, above: str, counts: Mapping[str, str]
    ) -> None:
        self._resolved = resolved
        self._flow = flow
        self._above = above
        self._counts = counts
        self._counters = {
            entry.node.id: counter_label(entry.node.id)
            for entry in resolved.nodes
            if entry.node.attempts is not None
        }

    def children(self) -> tuple[Child, ...]:
        """Return what the nodes become, the initial one first."""
        initial = self._resolved.chart.initial
        entries = sorted(self._resolved.nodes, key=lambda entry: entry.node.id != initial)
        found: list[Child] = []
        for entry in entries:
            self._lower(entry, found)
        return tuple(found)

    def _lower(self, entry: ResolvedNode, found: list[Child]) -> None:
        """Add what a node becomes: its counter, itself, and what parts its failures.

        What is entered first is added first: the first child of a container is its initial state.
        """
        node = entry.node
        exits = self._exits(entry)
        if node.attempts is not None:
            found.append(self._counter(entry, exits[EXHAUSTED]))
        choosers = [self._chooser(entry, exits[FAILED])] if node.on_error else []
        if node.on_error:
            exits[FAILED] = Exit(FAILED, chooser_label(node.id))
        own = tuple([exits[event] for event in _own_outcomes(entry)])
        if entry.use.is_timed:
            found.append(self._timed(entry, own, exits[TIMED_OUT]))
        else:
            found.append(Child(node.id, self._content(entry), own, self._remapping(entry)))
        found.extend(choosers)

    def _counter(self, entry: ResolvedNode, exhausted: Exit) -> Child:
        """Return the state that counts the attempts of a node, and that is entered before it."""
        node = entry.node
        return Child(
            counter_label(node.id),
            self._support(Support.COUNTER, attempts=node.attempts),
            (Exit(_COUNTED, node.id), exhausted),
            (("attempt", self._counts[f"{self._above}{node.id}"]),),
        )

    def _exits(self, entry: ResolvedNode) -> dict[str, Exit]:
        """Return where each event of a node leads."""
        if self._resolved.is_concurrent:
            return {
                when.event: Exit(when.event, condition.outcome)
                for condition in self._resolved.chart.conditions
                for when in condition.all_of
                if when.state == entry.node.id
            }
        counters = self._counters
        return {
            t.event: Exit(t.event, counters.get(t.target, t.target), t.autonomy)
            for t in entry.node.transitions
        }

    def _entry(self, target: str) -> str:
        """Return the label that a transition to a target leads to."""
        return self._counters.get(target, target)

    def _chooser(self, entry: ResolvedNode, otherwise: Exit) -> Child:
        """Return the state that leads a failure to where its code says."""
        routes = entry.node.on_error
        events = tuple(route_event(route) for route in routes)
        codes = codes_of_routes(routes, self._resolved.error_names)
        conditions = choose_by_code(zip(events, codes, strict=True), OTHER)
        chooser = self._support(Support.CHOOSER, outcomes=(*events, OTHER), conditions=conditions)
        exits = tuple(
            Exit(event, self._entry(route.target))
            for event, route in zip(events, routes, strict=True)
        )
        code = self._flow.outputs[entry.node.id][ERROR_CODE]
        return Child(
            chooser_label(entry.node.id),
            chooser,
            (*exits, otherwise._replace(outcome=OTHER)),
            (("input_value", code),),
        )

    def _timed(self, entry: ResolvedNode, own: tuple[Exit, ...], timed_out: Exit) -> Child:
        """Return the container of a node and its timer.

        The autonomy of a transition stands at the child, where the engine keeps to it.
        """
        remapping = self._remapping(entry)
        conditions = [Condition(e.outcome, ((RUN, e.outcome),)) for e in own]
        conditions.append(Condition(TIMED_OUT, ((TIMER, "done"),)))
        inputs, outputs = entry.use.inputs, entry.use.outputs
        passed = self._passed_counts(entry)
        keys = tuple((key, key) for key, _home in remapping)
        timer = self._support(Support.TIMER, wait_time=entry.node.timeout_s)
        container = machine.Container(
            Kind.CONCURRENCY,
            tuple(dict.fromkeys(condition.outcome for condition in conditions)),
            (*(n for n in inputs if (entry.node.id, n) not in self._flow.defaulted), *passed),
            (*outputs, *passed),
            children=(
                Child(
                    RUN,
                    self._content(entry),
                    tuple(Exit(e.outcome, e.outcome, e.autonomy) for e in own),
                    keys,
                ),
                Child(TIMER, timer, (Exit("done", TIMED_OUT, timed_out.autonomy),)),
            ),
            conditions=tuple(conditions),
        )
        leaving = {exit_.outcome: exit_.target for exit_ in (*own, timed_out)}
        exits = tuple(Exit(outcome, leaving[outcome]) for outcome in container.outcomes)
        return Child(entry.node.id, container, exits, remapping)

    def _content(self, entry: ResolvedNode) -> StateUse | BehaviorUse | machine.Container:
        """Return the state, behavior or container that a node is."""
        declaration = entry.use.declaration
        if entry.body is not None:
            return self._body(entry, entry.body)
        given = _arguments(entry)
        if isinstance(declaration, BehaviorClass):
            defaulted, node_id = self._flow.defaulted, entry.node.id
            kept = tuple(p.name for p in declaration.inputs if (node_id, p.name) in defaulted)
            return BehaviorUse(declaration, given, kept)
        if declaration is None:
            raise AssertionError(f"{entry.node.id} was lowered though its class is not known")
        return StateUse(declaration, _alias(declaration, entry.use.is_qualified), given)

    def _body(self, entry: ResolvedNode, body: ResolvedChart) -> machine.Container:
        """Return the container that a container of the chart becomes."""
        chart, passed = body.chart, self._passed_counts(entry)
        inside = _Lowering(body, body.flow, f"{self._above}{entry.node.id}/", self._counts)
        return machine.Container(
            _KINDS[body.runs],
            tuple(outcome.name for outcome in chart.outcomes),
            (*(port.name for port in chart.inputs), *passed),
            (*(port.name for port in chart.outputs), *passed),
            children=inside.children(),
            conditions=tuple(
                Condition(c.outcome, tuple((when.state, when.event) for when in c.all_of))
                for c in chart.conditions
            ),
        )

    def _passed_counts(self, entry: ResolvedNode) -> tuple[str, ...]:
        """Return the keys of the counts inside a node, which it passes through."""
        if entry.body is None:
            return ()
        inside = f"{self._above}{entry.node.id}/"
        return tuple(key for path, key in self._counts.items() if path.startswith(inside))

    def _remapping(self, entry: ResolvedNode) -> tuple[tuple[str, str], ...]:
        """Return the home of each key, in the order of the FlexBE App: inputs first."""
        node_id, flow = entry.node.id, self._flow
        read, written = flow.inputs.get(node_id, _NONE), flow.outputs.get(node_id, _NONE)
        outputs = [(name, written[name]) for name in entry.use.outputs if name not in read]
        if entry.body is None:
            return (*read.items(), *outputs)
        passed = [(key, key) for key in self._passed_counts(entry)]
        return (*read.items(), *passed, *outputs)

    def _support(self, wanted: Support, **values: Value) -> StateUse:
        """Return a state that an extension adds."""
        state = self._resolved.support[wanted]
        return StateUse(state, state.name, tuple(Pair(*item) for item in values.items()))


def _own_outcomes(entry: ResolvedNode) -> tuple[str, ...]:
    """Return the outcomes that the node itself can have, whatever is added around it."""
    return (entry.use.signature.outcomes if entry.use.signature else None) or ()


def _arguments(entry: ResolvedNode) -> tuple[Pair, ...]:
    """Return what is given to a class; what takes Python source has the name of a predicate."""
    given = given_values(entry).items()
    if not given:
        return ()
    taking_source = entry.use.taking_source
    if not taking_source:
        return tuple([Pair(name, value) for name, value in given])
    return tuple(
        Pair(name, PREDICATES[value] if isinstance(value, str) and name in taking_source else value)
        for name, value in given
    )


def _alias(state: StateClass, is_qualified: bool) -> str:
    """Return the name that a state class is imported under; the FlexBE App reads both forms."""
    return f"{state.package}__{state.name}" if is_qualified else state.name
