"""Random behaviors with random outcomes and commands, against a reference interpreter.

The reference runs each state and container as a generator that yields once per tick; closing a
generator ends the visit. It shares no code with the engine.
"""

from dataclasses import dataclass, field

from hypothesis import given, settings
from hypothesis import strategies as st

from flexbe_core.core import ConcurrencyContainer, OperatableStateMachine, PriorityContainer
from flexbe_core.engine import commands as c
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.errors import BehaviorFailure
from flexbe_core.engine.structure import definitions_below
from flexbe_core.engine.supervision import Supervision
from flexbe_core.testing import ScriptedState

OUTCOMES = ("x", "y")
BOOM = "boom"
UNDECLARED = "undeclared"
EVENTS = {"enter", "exit", "execute"}


# What is run


@dataclass(frozen=True)
class StateSpec:
    label: str
    script: tuple
    levels: tuple


@dataclass(frozen=True)
class MachineSpec:
    label: str
    children: tuple
    targets: dict  # (label, outcome) -> label or outcome
    is_priority: bool = False


@dataclass(frozen=True)
class ConcurrencySpec:
    label: str
    children: tuple
    conditions: tuple


@st.composite
def state_specs(draw, label):
    items = st.sampled_from([None, None, "x", "y", "x", BOOM, UNDECLARED])
    script = tuple(draw(st.lists(items, min_size=1, max_size=4)))
    return StateSpec(label, script, tuple(draw(st.integers(0, 3)) for _ in OUTCOMES))


@st.composite
def specs(draw, label, depth):
    kind = (
        draw(st.sampled_from(["state", "machine", "priority", "concurrency"])) if depth else "state"
    )
    if kind == "state":
        return draw(state_specs(label))
    return draw(container_specs(label, depth, kind))


@st.composite
def container_specs(draw, label, depth, kind):
    labels = [f"{label}{letter}" for letter in "abc"[: draw(st.integers(1, 3))]]
    children = tuple(draw(specs(name, depth - 1)) for name in labels)
    if kind == "concurrency":
        pairs = st.lists(
            st.tuples(st.sampled_from(labels), st.sampled_from(OUTCOMES)), min_size=1, max_size=2
        )
        conditions = draw(st.lists(st.tuples(st.sampled_from(OUTCOMES), pairs), max_size=3))
        return ConcurrencySpec(label, children, tuple(conditions))
    targets = {
        (name, outcome): draw(st.sampled_from([*labels, *OUTCOMES]))
        for name in labels
        for outcome in OUTCOMES
    }
    return MachineSpec(label, children, targets, kind == "priority")


COMMANDS = st.one_of(
    st.just(c.Pause()),
    st.just(c.Resume()),
    st.just(c.Repeat()),
    st.just(c.Lock("")),
    st.just(c.Unlock("")),
    st.builds(c.SetAutonomy, st.integers(0, 3)),
    st.just("force"),
)


# The reference


class FailedError(Exception):
    pass


@dataclass
class World:
    holds: bool
    level: int
    supervised: bool
    trace: list = field(default_factory=list)
    queue: list = field(default_factory=list)
    steps: dict = field(default_factory=dict)
    paused: bool = False
    locks: set = field(default_factory=set)
    priority: str | None = None
    claim: tuple | None = None

    def fail(self):
        if not self.holds:
            raise FailedError


def inside(path, other):
    return path == other or path.startswith(other + "/")


def run_state(spec, path, world, is_first):
    supervised = world.supervised and is_first
    entered, forced, repeat, stored = False, None, False, None
    try:
        while True:
            while supervised and world.queue and forced is None:
                command = world.queue.pop(0)
                if command == c.Pause():
                    world.paused = True
                elif command == c.Resume():
                    world.paused = False
                elif command == c.Repeat():
                    repeat = True
                elif command == c.Lock(""):
                    world.locks.add(path)
                elif command == c.Unlock(""):
                    world.locks.discard(path)
                elif command.target == spec.label:
                    forced = OUTCOMES[command.index]
            if supervised and world.paused and world.claim is None:
                world.claim, world.priority = (world.priority,), path
            if not world.paused and supervised and world.claim is not None:
                (world.priority,), world.claim = world.claim, None
            if (supervised and world.paused) or (stored is not None and path in world.locks):
                yield
                continue
            if not entered:
                entered = True
                world.trace.append((spec.label, "enter"))
            outcome, stored = stored if stored is not None else forced, None
            if outcome is None:
                world.trace.append((spec.label, "execute"))
                step = world.steps.get(path, 0)
                world.steps[path] = step + 1
                outcome = spec.script[min(step, len(spec.script) - 1)]
            if outcome in (BOOM, UNDECLARED):
                world.fail()
                yield
                continue
            blocked = False
            if supervised and outcome is not None:
                if path in world.locks:
                    stored, forced = outcome, None
                    yield
                    continue
                needed = spec.levels[OUTCOMES.index(outcome)]
                blocked = outcome != forced and needed >= world.level
            if supervised and repeat and (outcome is None or blocked):
                world.trace.append((spec.label, "exit"))
                entered = repeat = False
                outcome = None
            if outcome is not None and not blocked:
                return outcome
            yield
    finally:
        if entered:
            world.trace.append((spec.label, "exit"))


def run_machine(spec, path, world, is_first):
    children = {child.label: child for child in spec.children}
    before, claims = world.priority, False
    if spec.is_priority and (before is None or not inside(before, path)):
        world.priority, claims = path, True
    try:
        label = spec.children[0].label
        while True:
            outcome = yield from run_spec(children[label], f"{path}/{label}", world, is_first)
            label = spec.targets[label, outcome]
            if label not in children:
                return label
            yield
    finally:
        if claims:
            world.priority = before


def run_concurrency(spec, path, world, is_first):
    running = {
        child.label: run_spec(child, f"{path}/{child.label}", world, is_first and index == 0)
        for index, child in enumerate(spec.children)
    }
    results = {}
    try:
        while True:
            before = len(results)
            for label in list(running):
                at = f"{path}/{label}"
                claim = world.priority
                if claim is not None and not inside(claim, at) and not inside(at, claim):
                    continue
                try:
                    next(running[label])
                except StopIteration as end:
                    results[label] = end.value
                    del running[label]
            for outcome, pairs in spec.conditions if len(results) > before else ():
                if all(results.get(label) == result for label, result in pairs):
                    return outcome
            if not running and len(results) > before:
                world.fail()
            yield
    finally:
        for child in running.values():
            child.close()


def run_spec(spec, path, world, is_first):
    run = {StateSpec: run_state, MachineSpec: run_machine, ConcurrencySpec: run_concurrency}
    return run[type(spec)](spec, path, world, is_first)


# The engine


def build(spec, log):
    if isinstance(spec, StateSpec):
        script = [ValueError(BOOM) if item == BOOM else item for item in spec.script]
        return ScriptedState(script, OUTCOMES, log)
    if isinstance(spec, ConcurrencySpec):
        container = ConcurrencyContainer(spec.conditions, outcomes=OUTCOMES)
    else:
        kind = PriorityContainer if spec.is_priority else OperatableStateMachine
        container = kind(outcomes=OUTCOMES)
    with container:
        for child in spec.children:
            targets = {o: getattr(spec, "targets", {}).get((child.label, o), o) for o in OUTCOMES}
            levels = dict(zip(OUTCOMES, getattr(child, "levels", (0, 0)), strict=True))
            OperatableStateMachine.add(child.label, build(child, log), targets, levels)
    return container


def first_children(container):
    for state in container._supervised_children():
        yield state
        if hasattr(state, "_supervised_children"):
            yield from first_children(state)


def tick_engine(engine, now):
    """Return "runs", ("ended", outcome) or "failed"."""
    try:
        outcome = engine.run(now)
    except BehaviorFailure:
        engine.stop()
        return "failed"
    return "runs" if outcome is None else ("ended", outcome)


def tick_reference(run):
    try:
        next(run)
    except StopIteration as end:
        return ("ended", end.value)
    except FailedError:
        return "failed"
    return "runs"


@settings(max_examples=400, deadline=None, derandomize=True)
@given(
    spec=container_specs("r", 3, "machine"),
    holds=st.booleans(),
    supervised=st.booleans(),
    level=st.integers(0, 4),
    orders=st.lists(st.lists(COMMANDS, max_size=2), max_size=25),
)
def test_the_engine_does_what_the_reference_does(spec, holds, supervised, level, orders):
    log = []
    root = build(spec, log)
    engine = Engine(root, ErrorPolicy.HOLD if holds else ErrorPolicy.FAIL)
    engine.record = Supervision(autonomy_level=level)
    if supervised:
        for state in [root, *first_children(root)]:
            state._is_controlled = True
    world = World(holds, level, supervised)
    reference = run_machine(spec, "", world, True)

    ends = ["runs"]
    for tick, batch in enumerate(orders):
        for command in batch:
            order(engine, world, command)
        ends = [tick_engine(engine, float(tick)), tick_reference(reference)]
        assert ends[0] == ends[1], tick
        if ends[0] != "runs":
            break
        assert [entry for entry in log if entry[1] in EVENTS] == world.trace
    if ends[0] == "runs":
        engine.handle(c.Preempt())
        assert engine.run(1000.0) == "preempted"
        reference.close()
    # In which order siblings are exited at the end is nobody's business.
    assert sorted(entry for entry in log if entry[1] in EVENTS) == sorted(world.trace)
    assert engine.priority is None or world.paused
    for state in definitions_below(root):
        if isinstance(state, ScriptedState):
            events = [event for label, event in log if label == state.name]
            assert events.count("enter") == events.count("exit")


def order(engine, world, command):
    """Give a command to both; an outcome is forced in the state that is active in the engine."""
    leaf = engine.root.leaf()
    if command == "force":
        command = c.ForceOutcome(leaf.label if leaf else "none", 1)
    engine.handle(command)
    if isinstance(command, c.SetAutonomy):
        world.level = command.level
    elif world.supervised and (leaf is None or leaf.definition._is_controlled):
        world.queue.append(command)
