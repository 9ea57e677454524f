"""Check that values which share a home are not taken for each other.

Outputs that feed one output of the chart are one value. Who reads one of them by a connection, or
routes failures by it, must not get another output of the same state; and what is inside a container
must not find that the container itself has written over what it reads.
"""

from __future__ import annotations

from collections.abc import Iterator

from flexbe_synthesizer.core.chart.model import State
from flexbe_synthesizer.core.chart.names import ERROR_CODE
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import DataFlow
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.use import label


def check_homes(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the problems with values that share a home."""
    yield from _check_reads(resolved, flow)
    yield from _check_containers(resolved, flow)
    yield from _check_routes(resolved, flow)
    if resolved.is_concurrent:
        yield from _check_races(resolved, flow)


def _check_reads(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each connection whose value another output can replace."""
    for (taker, name), connection in flow.wiring.into_state.items():
        giver, output = connection.output_state_id, connection.output
        home = flow.outputs.get(giver, {}).get(output)
        if home is None or flow.inputs.get(taker, {}).get(name) != home:
            continue
        read = f"input '{name}' of {label(resolved.by_id[taker].node)}"
        other = _other_output(giver, output, flow)
        if other is not None:
            message = f"{read} is to come from '{output}' of '{giver}', whose output '{other}' is "
            message += f"the same value, '{home}'. Let them feed different outputs of the chart."
            yield Problem(connection.position(), ProblemKind.OVERWRITTEN_VALUE, message)


def _check_containers(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each container that writes over what is still read inside it."""
    for name, inputs in flow.inputs.items():
        entry = resolved.by_id[name]
        if isinstance(entry.node, State):
            continue  # it reads before it writes
        for key, home in inputs.items():
            own = [o for o, at in flow.outputs.get(name, {}).items() if at == home and o != key]
            if own:
                message = f"input '{key}' of {label(entry.node)} is the same value, '{home}', as "
                message += f"its output '{own[0]}', and may be overwritten while it is still "
                message += "read. Let the output feed another output of the chart."
                connection = flow.wiring.into_state.get((name, key))
                place = (connection or entry.node).position()
                yield Problem(place, ProblemKind.OVERWRITTEN_VALUE, message)


def _check_routes(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each state whose failures are routed by a value that is not the code."""
    for name, entry in resolved.by_id.items():
        if entry.node.on_error and ERROR_CODE in flow.outputs.get(name, {}):
            other = _other_output(name, ERROR_CODE, flow)
            if other is not None:
                message = f"ext:on_error of {label(entry.node)} reads '{ERROR_CODE}', and its "
                message += f"output '{other}' is the same value, "
                message += f"'{flow.outputs[name][ERROR_CODE]}'. Let them feed different outputs "
                message += "of the chart."
                yield Problem(
                    entry.node.position("on_error"), ProblemKind.OVERWRITTEN_VALUE, message
                )


def _check_races(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each input of the container that one state reads and another writes."""
    given = {port.name for port in resolved.chart.inputs}
    writers: dict[str, list[str]] = {}
    for name, homes in flow.outputs.items():
        for home in set(homes.values()) & given:
            writers.setdefault(home, []).append(name)
    for taker, inputs in flow.inputs.items():
        for name, home in inputs.items():
            others = [other for other in writers.get(home, ()) if other != taker]
            if others:
                entry = resolved.by_id[taker]
                message = f"input '{name}' of {label(entry.node)} reads '{home}' of "
                message += f"{resolved.title}, which '{others[0]}' writes at the same time, before "
                message += f"or after. Let '{others[0]}' feed an output of another name."
                connection = flow.wiring.into_state.get((taker, name))
                yield Problem(
                    (connection or entry.node).position(), ProblemKind.OVERWRITTEN_VALUE, message
                )


def _other_output(name: str, output: str, flow: DataFlow) -> str | None:
    """Return another output of a node with the home of this one."""
    homes = flow.outputs[name]
    return next((o for o, home in homes.items() if home == homes[output] and o != output), None)
