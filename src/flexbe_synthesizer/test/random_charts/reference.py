"""One run of a chart, as the documentation describes it.

Time passes in rounds: in each, every active state is executed once, and so are the states that the
README says are added (`X_attempts`, `X_error`, `X/timer`). A visit is a generator that yields at
the end of each round and returns an event.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from itertools import count

from scripted_states.script import Script

from random_charts.chart_xml import CHART, Node, Place, Scope
from random_charts.kinds import KINDS

ROUND_S = 0.25  # how much ROS time passes between two rounds
_PREDICATES: Mapping[str, Callable[[object], bool]] = {
    "is_true": bool,
    "is_false": lambda value: not value,
    "is_none": lambda value: value is None,
    "is_given": lambda value: value is not None,
}
Visit = Generator[None, None, str]
Order = Callable[[str, list[str]], list[str]]


class MissingError(Exception):
    """A state reads what nothing has written."""


class _Values:
    """What has been written in one visit to a chart or container."""

    def __init__(self, scope: Scope, node: str, around: _Values | None, given: Mapping) -> None:
        """Begin with what the caller gives, or with what is around, where `node` stands for it."""
        self._scope, self._node, self._around, self._given = scope, node, around, given
        self._written: dict[Place, tuple[int, object]] = {}
        self.outputs: dict[str, object] = {}

    def read(self, node: str, key: str) -> object:
        """Return what an input holds."""
        places = self._scope.sources(node, key)
        found = [self._written[place] for place in places if place in self._written]
        if found:
            return max(found, key=lambda written: written[0])[1]
        from_chart = [name for owner, name in places if owner == CHART]
        if not from_chart:
            raise MissingError(f"'{key}' of '{node}'")
        return self._input(from_chart[0])

    def _input(self, name: str) -> object:
        around = self._around
        if around is not None and around._scope.source(self._node, name) is not None:
            return around.read(self._node, name)
        if name in self._given:
            return self._given[name]
        if self._scope.inputs[name] is not ...:
            return self._scope.inputs[name]
        raise MissingError(f"input '{name}' of '{self._scope.name}'")

    def written(self, node: str, key: str) -> object:
        """Return what is in an output."""
        place = self._scope.place(node, key)
        if place not in self._written and place[0] == CHART:
            return self._input(place[1])
        if place not in self._written:
            raise MissingError(f"'{key}' of '{node}'")
        return self._written[place][1]

    def write(self, node: str, key: str, value: object, clock: int) -> None:
        """Put a value into an output, and so into what is around."""
        place = self._scope.place(node, key)
        self._written[place] = (clock, value)
        for output in self._scope.outputs:
            if place in self._scope.feeders(output):
                self.outputs[output] = value
                if self._around is not None:
                    self._around.write(self._node, output, value, clock)


class Reference:
    """One run.

    Attributes:
        ended: (round, path, event) of each state that ended, with those that are added.
        outcome: how the chart ended, None if it went on.
        outputs: the chart's outputs that were written.
        missing: what was read and had never been written, None if nothing was.
    """

    def __init__(
        self, chart: Scope, script: Script, given: Mapping[str, object], order: Order
    ) -> None:
        """Prepare to run a chart.

        Args:
            chart: the chart.
            script: what the states do.
            given: values of the chart's inputs.
            order: sorts the ids in a concurrency container, from its path, as the engine executes
                them in a round.
        """
        self._script, self._order = script, order
        self._clock = count()
        self._round = 0
        self._priority: str | None = None
        self._values = _Values(chart, "", None, given)
        self._visit = self._inside(chart, "", self._values, {})
        self.ended: list[tuple[int, str, str]] = []
        self.outcome: str | None = None
        self.missing: str | None = None

    @property
    def outputs(self) -> Mapping[str, object]:
        """Return the chart's outputs that were written."""
        return self._values.outputs

    def run(self, most_rounds: int) -> None:
        """Run until the chart ends."""
        try:
            while self._round < most_rounds:
                next(self._visit)
                self._round += 1
        except StopIteration as end:
            self.outcome = end.value
        except MissingError as error:
            self.missing = str(error)

    def _inside(self, scope: Scope, path: str, values: _Values, counts: dict) -> Visit:
        """Visit a chart or the content of a container; return its outcome."""
        if not scope.initial:
            return (yield from self._simultaneous(scope, path, values, counts))
        target = scope.initial
        while True:
            target = yield from self._node(scope.nodes[target], path, values, counts)
            if target in scope.outcomes:
                return target
            yield

    def _node(self, node: Node, above: str, values: _Values, counts: dict) -> Visit:
        """Visit a node with its counter and its routes; return where its event leads."""
        path = f"{above}/{node.id}"
        if node.attempts is not None:
            counts[path] = counts.get(path, 0) + 1
            event = "counted" if counts[path] <= node.attempts else "exhausted"
            self._end(f"{path}_attempts", event)
            if event == "exhausted":
                return node.events[event]
            yield
        event = yield from self._limited(node, path, values, counts)
        if event == "failed" and node.routes:
            yield
            code = values.written(node.id, "error_code")
            is_code = isinstance(code, int)
            fitting = [target for codes, target in node.routes if is_code and code in codes]
            self._end(f"{path}_error", fitting[0] if fitting else node.events[event])
            return fitting[0] if fitting else node.events[event]
        return node.events[event]

    def _limited(self, node: Node, path: str, values: _Values, counts: dict) -> Visit:
        """Visit a node and its timer; return the event."""
        if not node.is_timed:
            return (yield from self._own(node, path, values, counts))
        visit = self._own(node, f"{path}/run", values, counts)
        timer = self._timer(path, node.timeout_s)
        event, is_over = "", False
        try:
            while not event and not is_over:
                event = _next(visit)
                is_over = not self._waits(f"{path}/timer") and bool(_next(timer))
                if not event and not is_over:
                    yield
            return event or "timed_out"
        finally:
            visit.close()

    def _timer(self, path: str, left_s: float) -> Visit:
        """Wait until the time since the first round has passed; it does so while others wait."""
        end = self._round * ROUND_S + left_s
        while self._round * ROUND_S < end:
            yield
        self._end(f"{path}/timer", "done")
        return "done"

    def _own(self, node: Node, path: str, values: _Values, counts: dict) -> Visit:
        """Visit what a node is; return its outcome."""
        if node.scope is None:
            outcome = yield from self._state(node, path, values)
            self._end(path, outcome)
            return outcome
        given = {}
        counted = {} if node.tag == "behavior" else counts  # a behavior begins a run of its own
        inside = _Values(node.scope, node.id, values, given)
        if node.tag == "priority":
            return (yield from self._alone(node.scope, path, inside, counted))
        return (yield from self._inside(node.scope, path, inside, counted))

    def _alone(self, scope: Scope, path: str, values: _Values, counts: dict) -> Visit:
        before, self._priority = self._priority, path
        try:
            return (yield from self._inside(scope, path, values, counts))
        finally:
            self._priority = before

    def _state(self, node: Node, path: str, values: _Values) -> Visit:
        if node.type == "WaitState":
            end = self._round * ROUND_S + node.params["wait_time"]
            while self._round * ROUND_S < end:
                yield
            return "done"
        read = {key: values.read(node.id, key) for key in node.inputs}
        if node.type == "CheckConditionState":
            holds = _PREDICATES[node.params["predicate"]](read["input_value"])
            return "true" if holds else "false"
        if node.type == "OperatorDecisionState":
            return node.params["suggestion"]
        if node.type == "UserDataState":
            values.write(node.id, "data", node.params["data"], next(self._clock))
            return "done"
        self._script.entered.append((path, _arguments(node), read))
        plan = self._script.plan(path, node.own, node.outputs)
        for _ in range(plan.delay):
            yield
        for key in KINDS[node.type].written(plan.outcome, node.outputs):
            values.write(node.id, key, plan.values[key], next(self._clock))
        return plan.outcome

    def _simultaneous(self, scope: Scope, path: str, values: _Values, counts: dict) -> Visit:
        """Visit all nodes at once, until a condition holds; return its outcome."""
        visits = {
            name: self._limited(scope.nodes[name], f"{path}/{name}", values, counts)
            for name in self._order(path, list(scope.nodes))
        }
        events: dict[str, str] = {}
        try:
            while True:
                for name, visit in visits.items():
                    if name in events or self._waits(f"{path}/{name}"):
                        continue
                    event = _next(visit)
                    events |= {name: event} if event else {}
                for outcome, all_of in scope.conditions:
                    if all_of.items() <= events.items():
                        return outcome
                yield
        finally:
            for visit in visits.values():
                visit.close()

    def _waits(self, path: str) -> bool:
        """Return whether a priority container runs elsewhere."""
        running = self._priority
        return running is not None and not (_is_in(path, running) or _is_in(running, path))

    def _end(self, path: str, event: str) -> None:
        self.ended.append((self._round, path, event))


def _next(visit: Visit) -> str:
    """Carry on with a visit for a round; return the event if it ends, else nothing."""
    try:
        next(visit)
    except StopIteration as end:
        return end.value
    return ""


def _is_in(path: str, other: str) -> bool:
    return path == other or path.startswith(f"{other}/")


def _arguments(node: Node) -> Mapping[str, object]:
    """Return the constructor arguments that a state of scripted_states records."""
    if not KINDS[node.type].keeps_time:
        return {}
    given = {"timeout_s": 5.0, "topic": "ability", **node.params}
    given |= {} if node.topic is None else {"topic": node.topic}
    return given | ({} if node.timeout_s is None else {"timeout_s": node.timeout_s})
