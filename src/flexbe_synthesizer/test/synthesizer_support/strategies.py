"""For property tests: charts of any shape, drawn by Hypothesis, which whoever uses this needs.

The charts have the form of the language; whether they make sense is left to chance.
"""

from __future__ import annotations

import string
from typing import TypeVar

from hypothesis import strategies as st

from flexbe_synthesizer.core.chart.error_routes import format_routes, parse_routes
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Autonomy,
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

T = TypeVar("T")
NAMES = st.sampled_from(("A", "B b", "c_1", "d.e-f", "Grün", "done", "failed", "x", "y2"))
TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Cn", "Co"]))
TYPES = st.none() | st.sampled_from(["int", "string", "geometry_msgs/Pose"])
UNTYPED = st.none() | st.sampled_from(["int", "geometry_msgs/Pose"])  # any literal may stand there
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-9999, 9999) | st.floats(-9, 9) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text() | st.integers(0, 9), inner),
    max_leaves=6,
)
NONE, NO_TEXT = st.just(()), st.just("")
WILD_NAMES = st.text(string.ascii_letters + "äß_é -<>&'\"\t\n", min_size=1, max_size=8)


def charts(
    ids: st.SearchStrategy[str] = NAMES, types: st.SearchStrategy[str] = NAMES
) -> st.SearchStrategy[Chart]:
    """Return charts whose names are drawn from the strategies given."""
    nodes = st.recursive(_leaves(ids, types), lambda inner: _containers(ids, inner), max_leaves=5)
    of_string = st.builds(Input, ids, st.just("string"), st.none() | st.text())
    inputs = st.builds(Input, ids, UNTYPED, VALUES) | of_string
    return _bodies(ids, nodes, inputs, name=ids, initial=ids, description=TEXTS)


def _many(
    strategy: st.SearchStrategy[T], fewest: int = 0, most: int = 2
) -> st.SearchStrategy[tuple[T, ...]]:
    return st.lists(strategy, min_size=fewest, max_size=most).map(tuple)


POINTS = st.none() | st.tuples(st.integers(-99999, 99999), st.integers(-99999, 99999))


def _limits(ids: st.SearchStrategy[str]) -> dict[str, st.SearchStrategy[object]]:
    targets = ids.filter(lambda text: text == text.strip() and "\n" not in text)
    ranges = st.builds("{}-{}".format, st.integers(1, 30000), st.integers(30001, 32767))
    codes = ranges | st.integers(1, 32767).map(str) | st.sampled_from(["JAMMED", "serious_1"])
    routes = _many(st.builds(ErrorRoute, codes, targets), fewest=1).filter(_are_routes)
    return {
        "attempts": st.none() | st.integers(1, 10**6),
        "timeout_s": st.none() | st.floats(0.001, 1e9),
        "on_error": st.just(()) | routes,
        "at": POINTS,
        "transitions": _many(
            st.builds(Transition, ids, ids, st.none() | st.sampled_from(Autonomy)), most=3
        ),
    }


def _are_routes(routes: tuple[ErrorRoute, ...]) -> bool:
    """Return whether each code stands once."""
    try:
        return parse_routes(format_routes(routes)) == routes
    except ValueError:
        return False


def _leaves(
    ids: st.SearchStrategy[str], types: st.SearchStrategy[str]
) -> st.SearchStrategy[AnyNode]:
    parts = {
        "id": ids,
        "type": types,
        "inputs": _many(st.builds(Input, ids, TYPES)),
        "outputs": _many(st.builds(Output, ids, TYPES)),
        "params": _many(st.builds(Param, ids, VALUES)),
        **_limits(ids),
    }
    return st.builds(State, topic=st.none() | ids, **parts) | st.builds(Behavior, **parts)


def _containers(
    ids: st.SearchStrategy[str], inner: st.SearchStrategy[AnyNode]
) -> st.SearchStrategy[AnyNode]:
    def container(node_id: str) -> st.SearchStrategy[AnyNode]:
        def of(
            types: list[str],
            initial: st.SearchStrategy[str],
            conditions: st.SearchStrategy[tuple[Condition, ...]],
        ) -> st.SearchStrategy[AnyNode]:
            ports = st.builds(Input, ids, TYPES)
            name = st.just(node_id)
            body = _bodies(ids, inner, ports, name, initial=initial, conditions=conditions)
            type_ = st.sampled_from(types)
            return st.builds(Container, id=name, type=type_, body=body, **_limits(ids))

        conditions = _many(st.builds(Condition, ids, _many(st.builds(When, ids, ids), fewest=1)))
        others = [kind.value for kind in ContainerKind if kind is not ContainerKind.CONCURRENCY]
        concurrency = [ContainerKind.CONCURRENCY.value]
        return of(others, ids, NONE) | of(concurrency, NO_TEXT, conditions)

    return ids.flatmap(container)


def _bodies(
    ids: st.SearchStrategy[str],
    nodes: st.SearchStrategy[AnyNode],
    inputs: st.SearchStrategy[Input],
    name: st.SearchStrategy[str],
    initial: st.SearchStrategy[str],
    conditions: st.SearchStrategy[tuple[Condition, ...]] = NONE,
    description: st.SearchStrategy[str] = NO_TEXT,
) -> st.SearchStrategy[Chart]:
    return st.builds(
        Chart,
        name=name,
        initial=initial,
        outcomes=_many(st.builds(Outcome, ids), fewest=1, most=3),
        nodes=st.lists(nodes, min_size=1, max_size=3, unique_by=lambda node: node.id).map(tuple),
        inputs=_many(inputs),
        outputs=_many(st.builds(Output, ids, TYPES)),
        connections=_many(st.builds(Connection, ids, ids, ids, ids)),
        conditions=conditions,
        description=description,
    )
