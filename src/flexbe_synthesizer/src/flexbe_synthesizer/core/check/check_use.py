"""Warn of what is said and not used, and of what may not mean what it seems to."""

from __future__ import annotations

from collections.abc import Container, Iterator

from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import DataFlow
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.signature import StateClass
from flexbe_synthesizer.core.library.use import label


def check_use(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the warnings about inputs, outputs and abilities."""
    yield from _check_abilities(resolved)
    if any(entry.use.signature is None for entry in resolved.nodes):
        return  # who reads what is not known
    read = {*flow.read, *(output.name for output in resolved.chart.outputs)}
    yield from _check_inputs(resolved, {*read, *flow.wiring.passed_through})
    yield from _check_outputs(resolved, flow, read)
    yield from _check_shadows(resolved, flow)


def _check_abilities(resolved: ResolvedChart) -> Iterator[Problem]:
    """Warn of states whose goals go on after the state was left."""
    for entry in resolved.nodes:
        declaration = entry.use.declaration
        if isinstance(declaration, StateClass) and declaration.leaves_goals:
            message = f"{label(entry.node)} sends a goal and never cancels it: when it is left by "
            message += "preemption, by a timeout or by a container's end, the ability goes on "
            message += f"moving. Cancel the goal in on_exit of {declaration.name}."
            yield Problem(entry.node.position("type"), ProblemKind.UNCANCELLED_ABILITY, message)


def _check_inputs(resolved: ResolvedChart, read: Container[str]) -> Iterator[Problem]:
    """Warn of inputs of the chart or container that no state reads."""
    for port in resolved.chart.inputs:
        if port.name and port.name not in read:
            message = f"no state reads input '{port.name}' of {resolved.title}; delete it or "
            yield Problem(port.position(), ProblemKind.UNUSED_INPUT, message + "connect it.")


def _check_outputs(
    resolved: ResolvedChart, flow: DataFlow, read: Container[str]
) -> Iterator[Problem]:
    """Warn of outputs that a state declares and nothing reads."""
    for node, entry in resolved.by_id.items():
        for output in entry.node.outputs:
            home = flow.outputs.get(node, {}).get(output.name)
            if home is not None and home not in read:
                message = f"nothing reads output '{output.name}' of {label(entry.node)}, which the "
                message += "chart declares; delete the <output>, or connect it."
                yield Problem(output.position(), ProblemKind.UNUSED_OUTPUT, message)


def _check_shadows(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Warn of inputs that read the chart's value though a state writes another of that name."""
    shadowed = {port.name for port in resolved.chart.inputs}
    writers: dict[str, list[str]] = {}  # of a value of that name: its first two
    for node, homes in flow.outputs.items():
        for name, home in homes.items():
            if name in shadowed and home != name and len(writers.setdefault(name, [])) < 2:
                writers[name].append(node)
    if not writers:
        return
    for node, entry in resolved.by_id.items():
        for name in entry.use.inputs:
            others = [other for other in writers.get(name, ()) if other != node]
            is_connected = (node, name) in flow.wiring.into_state
            if others and not is_connected and flow.inputs[node].get(name) == name:
                message = f"input '{name}' of {label(entry.node)} reads the input of "
                message += f"{resolved.title}, though '{others[0]}' has an output of that name too;"
                message += " say with a <connection> which of them is meant."
                yield Problem(entry.node.position(), ProblemKind.SHADOWED_NAME, message)
