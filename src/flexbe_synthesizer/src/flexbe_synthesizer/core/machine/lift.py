"""Lift a plain FlexBE machine to the chart with the same meaning: the inverse of `lower`.

Counters, timers and choosers that `lower` would have added become extensions again; everything
else becomes a state, a behavior or a container of its own. Connections name the source of a value
where its name does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from flexbe_synthesizer.core.chart.error_routes import FAILED_EVENT, codes_of_event
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Condition,
    Connection,
    Container,
    ContainerKind,
    ErrorRoute,
    Input,
    Outcome,
    Output,
    Param,
    State,
    Transition,
    When,
)
from flexbe_synthesizer.core.library.signature import BehaviorClass, Signature, state_signature
from flexbe_synthesizer.core.machine.lower import chooser_label, counter_label
from flexbe_synthesizer.core.machine.machine import (
    PREDICATES,
    BehaviorUse,
    Child,
    Exit,
    Expression,
    Kind,
    Machine,
    Pair,
    StateUse,
    Value,
    is_choice_by_code,
    python_value,
)
from flexbe_synthesizer.core.machine.machine import Container as Machinery
from flexbe_synthesizer.core.machine.machine_reader import InexpressibleError

_KINDS = {
    Kind.STATE_MACHINE: ContainerKind.SEQUENCE,
    Kind.CONCURRENCY: ContainerKind.CONCURRENCY,
    Kind.PRIORITY: ContainerKind.PRIORITY,
}
_PREDICATE_NAMES = {expression.text: name for name, expression in PREDICATES.items()}


def lift(machine: Machine, file: str, *, is_outline: bool = False) -> Chart:
    """Return the chart that a machine comes from, or could come from.

    Args:
        machine: what to lift.
        file: what to call it in messages.
        is_outline: leave out what no chart can say. Which states there are, where they lead, and
            what feeds the outputs is then right all the same.

    Raises:
        InexpressibleError: if no chart says what the machine does.
    """
    folding = _Folding(machine, file)
    chart = folding.body(machine.root, machine.name, "")
    if folding.reasons and not is_outline:
        raise InexpressibleError(tuple(folding.reasons))
    return replace(chart, description=machine.description, author=machine.author)


class _Folding:
    """Folds the containers of one machine, and collects what no chart can say."""

    def __init__(self, machine: Machine, file: str) -> None:
        self._file = file
        self._counts = frozenset(_count_keys(machine.root))
        self._defaults = {key: value for key, value in machine.root.userdata}
        self.reasons: list[str] = []

    def _refuse(self, path: str, reason: str) -> None:
        self.reasons.append(f"{self._file}: {path or '/'}: {reason}")

    def body(self, container: Machinery, name: str, path: str) -> Chart:
        """Return the chart, or the content of a container, that a container is."""
        counts, by_label = self._counts, {child.label: child for child in container.children}
        counters = {c.label: c for c in container.children if _is_counter(c, by_label)}
        choosers = {c.label: c for c in container.children if _is_chooser(c, by_label)}
        counted = {counter_label(label): label for label in by_label}
        entries = {label: counted[label] for label in counters}
        parts = [c for c in container.children if c.label not in counters | choosers]
        is_concurrent = container.kind is Kind.CONCURRENCY
        nodes = []
        for child in parts:
            node = self._node(child, f"{path}/{child.label}", entries)
            if is_concurrent:
                node = replace(node, transitions=())
            counter = counters.get(counter_label(child.label))
            if counter is not None:
                node = _with_attempts(node, counter, entries)
            chooser = choosers.get(chooser_label(child.label))
            if chooser is not None:
                node = _with_routes(node, chooser, entries)
            nodes.append(node)
        first = container.children[0].label
        nodes.sort(key=lambda node: node.id != entries.get(first, first))
        chart = Chart(
            name,
            "" if is_concurrent else entries.get(first, first),
            outcomes=tuple(map(Outcome, container.outcomes)),
            nodes=tuple(nodes),
            inputs=tuple(
                self._input(key, path) for key in container.input_keys if key not in counts
            ),
            outputs=tuple(Output(key) for key in container.output_keys if key not in counts),
            conditions=tuple(
                Condition(c.outcome, tuple(When(*pair) for pair in c.pairs))
                for c in container.conditions
            ),
        )
        return self._with_flows(chart, parts, path)

    def _input(self, key: str, path: str) -> Input:
        value = None if path else self._defaults.get(key)
        return Input(key, default=None if isinstance(value, Expression) else value)

    def _node(self, child: Child, path: str, entries: dict[str, str]) -> AnyNode:
        """Return the node that a child is, with where its own outcomes lead."""
        timed = _timed(child)
        if timed is not None:
            return self._timed_node(child, *timed, path, entries)
        transitions = tuple(_transition(exit_, entries) for exit_ in child.exits)
        content = child.content
        if isinstance(content, Machinery):
            body = self.body(content, child.label, path)
            kind = _KINDS[content.kind].value
            return Container(child.label, kind, transitions, body=body)
        if isinstance(content, BehaviorUse):
            params = tuple(self._param(p.name, p.value, path) for p in content.parameters)
            return Behavior(child.label, content.behavior.name, transitions, params=params)
        params = tuple(self._param(p.name, p.value, path) for p in _chosen(content))
        return State(child.label, _class_name(content), transitions, params=params)

    def _timed_node(
        self, child: Child, run: Child, timer: Child, path: str, entries: dict[str, str]
    ) -> AnyNode:
        """Return the node that a container of a run and its timer stands for."""
        targets = {exit_.outcome: exit_.target for exit_ in child.exits}
        exits = [*run.exits, Exit("timed_out", "", timer.exits[0].autonomy)]
        leading = (e._replace(target=targets[e.outcome]) for e in exits)
        node = self._node(replace(run, label=child.label), path, entries)
        transitions = {e.outcome: _transition(e, entries) for e in leading}
        seconds = float(_number(timer, "wait_time"))
        return replace(node, transitions=tuple(transitions.values()), timeout_s=seconds)

    def _param(self, name: str, value: Value, path: str) -> Param:
        if isinstance(value, Expression):
            if value.text in _PREDICATE_NAMES:
                return Param(name, _PREDICATE_NAMES[value.text])
            self._refuse(path, f"parameter '{name}' is Python source: {value.text}")
            return Param(name, None)
        return Param(name, value)

    def _with_flows(self, chart: Chart, parts: Iterable[Child], path: str) -> Chart:
        """Return the chart with the connections that its children's remappings mean."""
        known = {port.name for port in chart.inputs}
        outputs = {port.name for port in chart.outputs}
        keys = [(child, *_keys(child)) for child in parts]
        reads = list(_homes(((child, inputs) for child, inputs, _ in keys), self._counts))
        writes = list(_homes(((child, outputs) for child, _, outputs in keys), self._counts))
        writers: dict[str, list[tuple[str, str]]] = {}
        for node, key, home in writes:
            writers.setdefault(home, []).append((node, key))
        flows, added = [], []
        for node, key, home in reads:
            sources = [(n, k) for n, k in writers.get(home, ()) if (n, k) != (node, key)]
            if home in known:
                if key != home:
                    flows.append(Connection(chart.name, home, node, key))
            elif len(sources) == 1:
                flows.append(Connection(*sources[0], node, key))
            elif not sources and not path and home in self._defaults:
                known.add(home)
                added.append(self._input(home, path))
                if key != home:
                    flows.append(Connection(chart.name, home, node, key))
            else:
                flows += [Connection(*source, node, key) for source in sources[:1]]
                who = ", ".join(n for n, _ in sources) or "no state"
                self._refuse(f"{path}/{node}", f"'{key}' reads '{home}', which {who} writes")
        for output in sorted(outputs - known):
            named = [(node, key, home) for node, key, home in writes if key == output]
            feeding = writers.get(output, [])
            if any(k != output for _, k in feeding) or any(h != output for *_, h in named):
                flows += [Connection(n, k, chart.name, output) for n, k in feeding]
        return replace(chart, connections=tuple(flows), inputs=(*chart.inputs, *added))


def _keys(child: Child) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the input and output keys of a child; of a timed one those of what it times."""
    content = child.content
    if isinstance(content, Machinery):
        return content.input_keys, content.output_keys
    offered: Signature | BehaviorClass
    if isinstance(content, BehaviorUse):
        offered = content.behavior
    else:
        given = {p.name: p.value for p in content.arguments if not isinstance(p.value, Expression)}
        offered = state_signature(content.state, given)
    return tuple(p.name for p in offered.inputs), tuple(p.name for p in offered.outputs)


def _homes(
    keys: Iterable[tuple[Child, tuple[str, ...]]], counts: frozenset[str]
) -> Iterator[tuple[str, str, str]]:
    """Yield (node, key, home) of the keys of children that have a home in their container."""
    for child, names in keys:
        homes = dict(child.remapping)
        for key in names:
            if key in homes and key not in counts:
                yield child.label, key, homes[key]


def _transition(exit_: Exit, entries: dict[str, str]) -> Transition:
    return Transition(exit_.outcome, entries.get(exit_.target, exit_.target), exit_.autonomy)


def _class_name(use: StateUse) -> str:
    """Return how a chart names a state class; one imported under an alias with its package."""
    return f"{use.state.package}/{use.state.name}" if use.alias != use.state.name else use.alias


def _is_a(child: Child, package: str, name: str) -> bool:
    content = child.content
    return isinstance(content, StateUse) and (content.state.package, content.state.name) == (
        package,
        name,
    )


def _chosen(use: StateUse) -> tuple[Pair, ...]:
    """Return the arguments of a state that say something.

    The App writes the defaults of all parameters, and a behavior of a chart one of them where the
    chart gives none.
    """
    defaults = [(p.name, p.default_source) for p in use.state.parameters if p.default_source]
    given = [(p.name, python_value(p.value)) for p in use.arguments]
    if given != defaults[:1] and len(given) < len(use.state.parameters):
        return use.arguments
    return tuple(p for p, pair in zip(use.arguments, given, strict=True) if pair not in defaults)


def _number(child: Child, name: str) -> float:
    """Return an argument of a state that an extension has added."""
    arguments = child.content.arguments if isinstance(child.content, StateUse) else ()
    value = next((pair.value for pair in arguments if pair.name == name), None)
    if not isinstance(value, int | float):
        raise InexpressibleError((f"{child.label}: '{name}' is no number",))
    return value


def _is_counter(child: Child, by_label: dict[str, Child]) -> bool:
    """Return whether a child counts the attempts of the one that it is named after."""
    targets = {e.outcome: e.target for e in child.exits}
    return (
        _is_a(child, "remodel_states", "CountAttemptsState")
        and targets.keys() == {"counted", "exhausted"}
        and targets["counted"] in by_label
        and child.label == counter_label(targets["counted"])
        and "attempt" in dict(child.remapping)
    )


def _is_chooser(child: Child, by_label: dict[str, Child]) -> bool:
    """Return whether a child routes the failures of the one that it is named after."""
    owner = next((label for label in by_label if chooser_label(label) == child.label), None)
    events = [e.outcome for e in child.exits[:-1]]
    return (
        owner is not None
        and _is_a(child, "flexbe_states", "DecisionState")
        and bool(events)
        and all(map(codes_of_event, events))
        and is_choice_by_code(_source(child, "conditions"), events, child.exits[-1].outcome)
    )


def _source(child: Child, name: str) -> str:
    """Return the Python source of an argument of a state; empty if it has none."""
    arguments = child.content.arguments if isinstance(child.content, StateUse) else ()
    values = (pair.value for pair in arguments if pair.name == name)
    return next((value.text for value in values if isinstance(value, Expression)), "")


def _count_keys(container: Machinery) -> Iterator[str]:
    """Yield the userdata keys of all counts."""
    by_label = {child.label: child for child in container.children}
    for child in container.children:
        if _is_counter(child, by_label):
            yield dict(child.remapping)["attempt"]
        if isinstance(child.content, Machinery):
            yield from _count_keys(child.content)


def _timed(child: Child) -> tuple[Child, Child] | None:
    """Return the run and the timer of a child that only bounds a time, else None."""
    content = child.content
    if not isinstance(content, Machinery) or content.kind is not Kind.CONCURRENCY:
        return None
    by_label = {inner.label: inner for inner in content.children}
    if by_label.keys() != {"run", "timer"}:
        return None
    run, timer = by_label["run"], by_label["timer"]
    is_timed = (
        _is_a(timer, "flexbe_states", "WaitState")
        and bool(timer.exits)
        and content.conditions[-1:] == (("timed_out", (("timer", "done"),)),)
        and {"timed_out", *(e.outcome for e in run.exits)} <= {e.outcome for e in child.exits}
    )
    return (run, timer) if is_timed else None


def _with_attempts(node: AnyNode, counter: Child, entries: dict[str, str]) -> AnyNode:
    exhausted = next(e for e in counter.exits if e.outcome == "exhausted")
    transitions = (*node.transitions, _transition(exhausted, entries))
    attempts = int(_number(counter, "attempts"))
    return replace(node, transitions=transitions, attempts=attempts)


def _with_routes(node: AnyNode, chooser: Child, entries: dict[str, str]) -> AnyNode:
    *routed, other = (_transition(exit_, entries) for exit_ in chooser.exits)
    transitions = tuple(
        replace(other, event=FAILED_EVENT) if t.event == FAILED_EVENT else t
        for t in node.transitions
    )
    routes = []
    for transition in routed:
        codes = codes_of_event(transition.event)
        if codes is not None:
            routes.append(ErrorRoute(codes, transition.target))
    return replace(node, transitions=transitions, on_error=tuple(routes))
