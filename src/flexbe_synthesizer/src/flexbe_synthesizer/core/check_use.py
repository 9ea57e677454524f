"""Warn of what is said and not used, and of what may not mean what it seems to."""

from __future__ import annotations

from collections.abc import Iterator

from flexbe_synthesizer.core.data_flow import DataFlow, Key, Wiring, ports
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, label
from flexbe_synthesizer.core.signature import StateClass


def check_use(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the warnings about inputs, outputs and abilities."""
    yield from _check_abilities(resolved)
    if any(entry.signature is None for entry in resolved.nodes):
        return  # who reads what is not known
    wiring = Wiring(resolved)
    yield from _check_inputs(resolved, flow, wiring)
    yield from _check_outputs(resolved, flow)
    yield from _check_shadows(resolved, flow, wiring)


def _check_abilities(resolved: ResolvedChart) -> Iterator[Problem]:
    """Warn of states whose goals go on after the state was left."""
    for entry in resolved.nodes:
        declaration = entry.declaration
        if isinstance(declaration, StateClass) and declaration.leaves_goals:
            message = f"{label(entry.node)} sends a goal and never cancels it: when it is left by "
            message += "preemption, by a timeout or by a container's end, the ability goes on "
            message += f"moving. Cancel the goal in on_exit of {declaration.name}."
            yield Problem(entry.node.position("type"), Code.UNCANCELLED_ABILITY, message)


def _check_inputs(resolved: ResolvedChart, flow: DataFlow, wiring: Wiring) -> Iterator[Problem]:
    """Warn of inputs of the chart or container that no state reads."""
    read = {*flow.inputs.values(), *wiring.passed_through}
    read |= {output.name for output in resolved.chart.outputs}  # the same value, given on
    for port in resolved.chart.inputs:
        if port.name and port.name not in read:
            message = f"no state reads input '{port.name}' of {resolved.title}; delete it or "
            yield Problem(port.position(), Code.UNUSED_INPUT, message + "connect it.")


def _check_outputs(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Warn of outputs that a state declares and nothing reads."""
    read = {*flow.inputs.values(), *(output.name for output in resolved.chart.outputs)}
    for name, entry in resolved.by_id.items():
        for output in entry.node.outputs:
            home = flow.outputs.get(Key(name, output.name))
            if home is not None and home not in read:
                message = f"nothing reads output '{output.name}' of {label(entry.node)}, which the "
                message += "chart declares; delete the <output>, or connect it."
                yield Problem(output.position(), Code.UNUSED_OUTPUT, message)


def _check_shadows(resolved: ResolvedChart, flow: DataFlow, wiring: Wiring) -> Iterator[Problem]:
    """Warn of inputs that read the chart's value though a state writes another of that name."""
    writers: dict[str, list[str]] = {}
    for key, home in flow.outputs.items():
        if home != key.name:
            writers.setdefault(key.name, []).append(key.node)
    for name, entry in resolved.by_id.items():
        for port in ports(entry)[0]:
            key = Key(name, port.name)
            others = [other for other in writers.get(port.name, ()) if other != name]
            if others and key not in wiring.into_state and flow.inputs.get(key) == port.name:
                message = f"input '{port.name}' of {label(entry.node)} reads the input of "
                message += f"{resolved.title}, though '{others[0]}' has an output of that name too;"
                message += " say with a <connection> which of them is meant."
                yield Problem(entry.node.position(), Code.SHADOWED_NAME, message)
