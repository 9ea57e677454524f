"""Check that extensions stand where they can be lowered to plain FlexBE."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.error_routes import codes_of_routes, is_named
from flexbe_synthesizer.core.chart.model import AnyNode, Container, ContainerKind, walk_nodes
from flexbe_synthesizer.core.chart.names import ERROR_CODE, FAILED
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode
from flexbe_synthesizer.core.library.use import label


def check_extensions(entry: ResolvedNode, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the limits and error routes of a node."""
    if resolved.is_concurrent:
        yield from _check_side_by_side(entry)
    elif entry.node.on_error:
        yield from _check_routes(entry, resolved)


def check_priorities(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each priority container inside another one, and for each with a timer."""
    for entry in resolved.nodes:
        if entry.body is not None and entry.body.runs is ContainerKind.PRIORITY:
            yield from _check_timer(entry.node)
    if resolved.runs is not ContainerKind.PRIORITY:
        return
    for node in walk_nodes(resolved.chart):
        if isinstance(node, Container) and node.runs is ContainerKind.PRIORITY:
            message = f"container '{node.id}' has priority already, since '"
            message += f"{resolved.chart.name}' around it has, and FlexBE cannot nest them; "
            message += "make it an <ext:container>."
            yield Problem(node.position(), ProblemKind.MISPLACED_ELEMENT, message)


def _check_timer(node: AnyNode) -> Iterator[Problem]:
    """Yield a problem if a priority container has a timer, which would wait while it runs."""
    if node.timeout_s is not None:
        message = f"ext:timeout_s at {label(node)}: while a priority container runs, nothing beside"
        message += " it does, and its timer is beside it. Put what is in it into an <ext:container>"
        message += " inside it, with ext:timeout_s there."
        yield Problem(node.position("timeout_s"), ProblemKind.UNKNOWN_EXTENSION, message)


def _check_side_by_side(entry: ResolvedNode) -> Iterator[Problem]:
    """Yield what cannot stand at a state that starts together with others."""
    node = entry.node
    if node.attempts is not None:
        message = f"ext:attempts at {label(node)}, which is entered with its concurrency container;"
        message += " put it at the container."
        yield Problem(node.position("attempts"), ProblemKind.UNKNOWN_EXTENSION, message)
    if node.on_error:
        message = f"ext:on_error at {label(node)}, which leads nowhere by itself; put the state "
        message += "into an <ext:container> here, with ext:on_error inside."
        yield Problem(node.position("on_error"), ProblemKind.UNKNOWN_EXTENSION, message)
    for transition in node.transitions:
        message = f"a <transition> of {label(node)} inside a concurrency container; what its "
        message += 'events lead to say <ext:condition outcome="..."> elements of the container.'
        yield Problem(transition.position(), ProblemKind.MISPLACED_ELEMENT, message)


def _check_routes(entry: ResolvedNode, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the error routes of a node."""
    node, signature = entry.node, entry.use.signature
    position = node.position("on_error")
    if signature is not None and signature.outcomes is not None and not entry.use.has_own(FAILED):
        message = f"ext:on_error routes the outcome '{FAILED}' by code, and {signature.title} has "
        message += f"none; its outcomes: {names.quoted(signature.outcomes)}."
        yield Problem(position, ProblemKind.UNKNOWN_EVENT, message)
    found = entry.use.outputs
    if signature is not None and ERROR_CODE not in found:
        message = f"ext:on_error reads the output '{ERROR_CODE}', and {signature.title} has none; "
        yield Problem(
            position, ProblemKind.UNKNOWN_OUTPUT, f"{message}its outputs: {names.quoted(found)}."
        )
    limit = signature.effect(FAILED) if signature is not None and ERROR_CODE in found else None
    if signature is not None and limit is not None and ERROR_CODE not in limit.certain:
        message = f"ext:on_error reads the output '{ERROR_CODE}', which {signature.title} does not "
        message += f"always write when it ends with '{FAILED}'; write it on each path to "
        message += f"'{FAILED}', or drop ext:on_error."
        yield Problem(position, ProblemKind.READ_BEFORE_WRITE, message)
    yield from _check_codes(node, resolved.error_names)
    known = set(resolved.targets)
    for route in node.on_error:
        if route.target not in known:
            hint = names.allowed(route.target, resolved.targets)
            message = f"'{route.target}' is neither a state, a behavior nor an outcome; {hint}"
            yield Problem(position, ProblemKind.UNKNOWN_TARGET, message)


def _check_codes(node: AnyNode, error_names: Mapping[str, tuple[int, ...]]) -> Iterator[Problem]:
    """Yield a problem for each error route with an unknown name, or that no code can take."""
    position = node.position("on_error")
    for route, codes in zip(
        node.on_error, codes_of_routes(node.on_error, error_names), strict=True
    ):
        if is_named(route) and route.codes not in error_names:
            message = f"no error code, and no class of error codes, has the name '{route.codes}'; "
            message += names.allowed(route.codes, error_names)
            yield Problem(position, ProblemKind.UNKNOWN_ERROR_CODE, message)
        elif not codes:
            message = f"the route of '{route.codes}' is never taken: the routes before it take all "
            message += "its error codes; put it before them."
            yield Problem(position, ProblemKind.INVALID_VALUE, message)
