"""Decompose a task into macro operations and actions, by the methods of its use case.

As in SHOP, the tasks of a method are done in their order, on a state that is carried along; as in
TLPlan, rules prune what must not be. The state holds what is known: if an action needs a fact that
is unknown, or that an earlier action has invalidated, the action that observes it is inserted
before. The methods of a task stand in the order in which they are preferred: the first that holds
and can be carried out is taken, or one after it that says `if_cheaper` and is expected to cost
less, failures included.

    cost of a decomposition = sum over its actions of: expected time of up to `attempts` calls
                              + failure_s x the probability that all of these fail
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from remodel_production.errors import InfeasibleError
from remodel_tasks.core.condition import Features, Value
from remodel_tasks.core.decomposition.decomposed import Decomposition, Limits, Rejected, Step
from remodel_tasks.core.orders.work_order import Access, Route, RouteClip, Task
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.use_case.model import (
    INSERTED,
    NOTHING,
    Action,
    Expectation,
    Expectations,
    Macro,
    Method,
    Scope,
    Subtask,
    UseCase,
)


@dataclass(frozen=True)
class _Pending:
    """A task or an action that is still to be decomposed or done."""

    macro: Macro
    subtask: Subtask
    end: End | None
    route: Route
    methods: tuple[tuple[str, str], ...] = ()
    clip: RouteClip | None = None


@dataclass(frozen=True)
class _State:
    """What holds after some steps.

    Attributes:
        known: facts, with what they are about.
        tool: that the arm needs; empty: any.
        passed_over: how many preferred methods were not taken.
    """

    steps: tuple[Step, ...] = ()
    known: frozenset[tuple[str, str]] = frozenset()
    tool: str = ""
    passed_over: int = 0
    cost_s: float = 0.0

    @property
    def rank(self) -> tuple[int, float]:
        """What is made least."""
        return self.passed_over, self.cost_s


class Decomposer:
    """Decomposes the tasks of one use case."""

    def __init__(
        self,
        use_case: UseCase,
        components: dict[str, dict[str, Value]],
        component_of: dict[str, str],
        expectations: Expectations | None = None,
        access: dict[str, Access] | None = None,
    ) -> None:
        """Take what tasks refer to.

        Args:
            use_case: whose methods count.
            components: their characteristics, by name.
            component_of: by the name of a terminal.
            expectations: of abilities; None: those that the use case states.
            access: to terminals, by name; nothing is known of others.
        """
        self._access = access or {}
        self.use_case = use_case
        self._components = components
        self._component_of = component_of
        self._expectations = expectations or use_case.expectations

    def decompose(
        self, task: Task, first: End, limits: Limits | None = None, *, hands_over: bool = False
    ) -> Decomposition:
        """Return the cheapest decomposition of a task whose `first` end is inserted first.

        Raises:
            InfeasibleError: if there is none, with what rules out each method.
        """
        return _Run(self, task, first, limits or Limits()).best(hands_over=hands_over)

    def features(self, task: Task, route: Route, end: End | None) -> Features:
        """Return what conditions can ask about a task, on one of its routes, at one of its ends."""
        use_case = self.use_case
        stated = {c.name: c.default for c in use_case.task_characteristics.values()}
        features: dict[str, Value] = {**stated, **task.characteristics}
        features |= {"length_m": route.length_m, "clips": len(route.clips)}
        if end is not None:
            component = self._components[self._component_of[task.terminals[end]]]
            for characteristic in use_case.component_characteristics.values():
                value = component.get(characteristic.name, characteristic.default)
                features[f"component.{characteristic.name}"] = value
        return {**features, **self.access(task, end).features}

    def expected(self, action: Action, features: Features) -> Expectation:
        """Return what is expected of all attempts at an action."""
        recovery = [self.use_case.actions[n] for n in (action.recover, action.on_failure) if n]
        attempts = max(other.attempts for other in (action, *recovery))
        between_s = sum(self._once(other, features).duration_s for other in recovery)
        return self._once(action, features).tried(attempts, between_s)

    def _once(self, action: Action, features: Features) -> Expectation:
        once = NOTHING
        for ability in action.abilities:
            once = once.then(self._expectations.expect(ability, features))
        return once

    def access(self, task: Task, end: End | None) -> Access:
        """Return the access to the terminal of a task's end, as far as it is known."""
        return Access() if end is None else self._access.get(task.terminals[end], Access())

    def subject(self, task: Task, fact: str, end: End | None) -> str:
        """Return what a fact is about: the task, or the component at the end."""
        if self.use_case.facts[fact].of is Scope.TASK or end is None:
            return task.name
        return self._component_of[task.terminals[end]]


class _Run:
    """The search for one task's cheapest decomposition.

    What comes later depends on what is known and on the tool in the hand alone, so that of the
    states that agree in both only the cheapest is followed.
    """

    def __init__(self, decomposer: Decomposer, task: Task, first: End, limits: Limits) -> None:
        self._d = decomposer
        self._task = task
        self._first = first
        self._limits = limits
        self._rejected: dict[tuple[str, str], str] = {}  # methods that cannot be taken
        self._outranked: dict[tuple[str, str], str] = {}  # those that could
        self._impossible: set[str] = set()  # tasks that none of their methods could do
        # Many states of the search ask for the same.
        self._features: dict[tuple[float, int, End | None], Features] = {}
        self._expected: dict[tuple[str, float, int, End | None], Expectation] = {}

    def best(self, *, hands_over: bool) -> Decomposition:
        ended: list[tuple[Route, _State]] = []
        for number, route in enumerate(self._task.routes, 1):
            barred = [s for s in route.segments if s in self._limits.segments]
            if barred:
                name = self._limits.segments[barred[0]]
                self._impossible.add("route")
                self._reject("route", str(number), f"goes through {barred[0]} (`{name}`)")
            else:
                states = self._all(self._sequence(route, hands_over=hands_over), [_State()])
                ended += [(route, state) for state in states]
        if not ended:
            reasons = "; ".join(
                f"{task} {method}: {why}"
                for (task, method), why in self._rejected.items()
                if task in self._impossible
            )
            raise InfeasibleError(
                f"task {self._task.name}: no method of {self._d.use_case.file_name} does it: "
                f"{reasons}"
            )
        route, state = min(ended, key=lambda pair: pair[1].rank)
        for number, other in enumerate(self._task.routes, 1):
            ranks = [found.rank for ended_route, found in ended if ended_route is other]
            if other is not route and ranks:
                self._outranked["route", str(number)] = _behind(min(ranks), state.rank)
        taken = {pair for step in state.steps for pair in step.methods}
        rejected = tuple(
            Rejected(*pair, why)
            for pair, why in (self._outranked | self._rejected).items()
            if pair not in taken
        )
        return Decomposition(
            self._task, route, self._first, state.steps, cost_s=state.cost_s, rejected=rejected
        )

    def _sequence(self, route: Route, *, hands_over: bool) -> list[_Pending]:
        """Return the macro operations of the task."""
        first, second = self._first, self._first.other
        route = route if first is End.A else route.reversed
        parts = [route]
        if hands_over and self._task.meeting_mm is not None:
            parts = list(route.split(self._task.meeting_mm))
        ends = {Macro.INSERT: [first, second]}
        routes = {Macro.ROUTE: parts}
        middle = [Macro.ROUTE, Macro.HAND_OVER, Macro.ROUTE] if len(parts) > 1 else [Macro.ROUTE]
        return [
            _Pending(
                macro,
                Subtask(macro.value),
                ends[macro].pop(0) if macro in ends else None,
                routes[macro].pop(0) if macro in routes else route,
            )
            for macro in (Macro.PICK, Macro.INSERT, *middle, Macro.INSERT, Macro.FIX)
        ]

    def _all(self, pending: Sequence[_Pending], states: list[_State]) -> list[_State]:
        """Return the states after all of some tasks, one after another."""
        for head in pending:
            states = self._do(head, states)
        return states

    def _do(self, head: _Pending, states: list[_State]) -> list[_State]:
        if head.subtask.for_each_clip:
            once = replace(head, subtask=Subtask(head.subtask.name))
            legs = zip(head.route.clips, head.route.legs(), strict=False)
            return self._all([replace(once, clip=clip, route=leg) for clip, leg in legs], states)
        if head.subtask.name in self._d.use_case.actions:
            return _cheapest(after for s in states for after in self._act(head, s))
        return self._choose(head, states)

    def _choose(self, head: _Pending, states: list[_State]) -> list[_State]:
        """Return the states after a task, done by each method that can do it."""
        task = head.subtask.name
        features = self._features_of(head)
        after: dict[str, list[_State]] = {}
        passed_over = -1
        for method in self._d.use_case.methods[task]:
            if not method.when.holds(features):
                self._reject(task, method.name, method.when.reason(features))
                continue
            if why := self._limits.methods.get((task, method.name)):
                self._reject(task, method.name, why)
                continue
            path = (*head.methods, (task, method.name))
            inner = [
                replace(head, subtask=sub, methods=path, route=self._part(head.route, method, sub))
                for sub in method.subtasks
            ]
            passed_over += not (method.if_cheaper and after)
            after[method.name] = [
                replace(state, passed_over=state.passed_over + passed_over)
                for state in self._all(inner, states)
            ]
        ranks = {name: min(s.rank for s in found) for name, found in after.items() if found}
        if states and not ranks:
            self._impossible.add(task)
        for name, rank in ranks.items():
            if rank > min(ranks.values()):
                self._outranked.setdefault((task, name), _behind(rank, min(ranks.values())))
        return _cheapest(state for found in after.values() for state in found)

    def _part(self, route: Route, method: Method, subtask: Subtask) -> Route:
        """Return the part of a route that a subtask is about: beside clips, what they leave."""
        if subtask.for_each_clip or not any(sub.for_each_clip for sub in method.subtasks):
            return route
        return route.legs()[-1]

    def _act(self, head: _Pending, state: _State) -> list[_State]:
        """Return the state after an action and the observations that it needs, or none."""
        action = self._d.use_case.actions[head.subtask.name]
        for fact, _ in action.needs:
            if (fact, self._d.subject(self._task, fact, head.end)) not in state.known:
                look = Subtask(self._d.use_case.facts[fact].look)
                macro = self._observing(head, self._d.use_case.facts[fact].of)
                observed = self._act(replace(head, subtask=look, macro=macro), state)
                return [after for s in observed for after in self._act(head, s)]
        features = self._features_of(head)
        expected = self._expected_of(action, head)
        access = self._d.access(self._task, head.end)
        done = (head.macro, action, head.end, head.clip, head.route, head.methods)
        step = Step(*done, expected=expected, access=access, features=features)
        why = self._forbidden(step, features, state)
        if why:
            for task, method in head.methods[-1:]:
                self._reject(task, method, why)
            return []
        known = {pair for pair in state.known if pair[0] not in action.forgets}
        known |= {(f, self._d.subject(self._task, f, head.end)) for f, _ in action.reveals}
        failure_s = self._d.use_case.cell.failure_s * (1 - expected.success)
        cost_s = state.cost_s + expected.duration_s + failure_s
        tool = state.tool or action.tool
        steps = (*state.steps, step)
        return [_State(steps, frozenset(known), tool, state.passed_over, cost_s=cost_s)]

    def _features_of(self, head: _Pending) -> Features:
        key = (head.route.length_m, len(head.route.clips), head.end)
        if key not in self._features:
            features = self._d.features(self._task, head.route, head.end)
            if head.end is not None:
                order = "first" if head.end is self._first else "second"
                features = {**features, INSERTED: order}
            self._features[key] = features
        return self._features[key]

    def _expected_of(self, action: Action, head: _Pending) -> Expectation:
        key = (action.name, head.route.length_m, len(head.route.clips), head.end)
        if key not in self._expected:
            self._expected[key] = self._d.expected(action, self._features_of(head))
        return self._expected[key]

    def _observing(self, head: _Pending, scope: Scope) -> Macro:
        """Return the macro operation to which the time of an observation counts.

        An insertion lasts as long whichever end comes first.
        """
        if scope is Scope.COMPONENT:
            return Macro.LOCATE
        if head.macro is Macro.INSERT:
            return Macro.PICK if head.end is self._first else Macro.ROUTE
        return head.macro

    def _forbidden(self, step: Step, features: Features, state: _State) -> str:
        """Return why a step must not come next; empty if it may."""
        action = step.action
        limit, name = self._limits.force_n.get(self._task.name, (math.inf, ""))
        if step.force_n > limit:
            return f"{action.name} pushes with {step.force_n:g} N, over {limit:g} N (`{name}`)"
        if step.force_n < action.force_n and not action.yields:
            return (
                f"{action.name} pushes with {action.force_n:g} N, over {step.force_n:g} N that "
                f"the terminal bears"
            )
        if action.tool and state.tool not in ("", action.tool):
            return f"{action.name} needs {action.tool} while {state.tool} has the hand full"
        for rule in self._d.use_case.rules:
            if rule.never == action.name and rule.when.holds(features):
                return f"{action.name} is ruled out by `{rule.name}`"
        return ""

    def _reject(self, task: str, method: str, reason: str) -> None:
        self._rejected.setdefault((task, method), reason)


def _cheapest(states: Iterable[_State]) -> list[_State]:
    """Return the cheapest of the states that agree in what matters later; of equals the first."""
    best: dict[tuple[frozenset[tuple[str, str]], str], _State] = {}
    for state in states:
        key = (state.known, state.tool)
        if key not in best or state.rank < best[key].rank:
            best[key] = state
    return list(best.values())


def _behind(rank: tuple[int, float], best: tuple[int, float]) -> str:
    """Return why what has one rank was not taken, and what has a better one was."""
    if rank[0] > best[0]:
        return "comes after one that can be taken"
    return f"is expected to cost {rank[1] - best[1]:.1f} s more"
