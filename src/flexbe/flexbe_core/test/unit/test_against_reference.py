"""Random behaviors with random outcomes, failures and commands, against a reference interpreter.

The reference runs each state and container as a generator that yields once per tick; closing a
generator ends the visit. It shares no code with the engine. All of a run follows from its seed.
"""

import random
from dataclasses import dataclass, field

import pytest

from flexbe_core.core import ConcurrencyContainer, OperatableStateMachine, PriorityContainer
from flexbe_core.engine import supervision as c
from flexbe_core.engine.definitions import definitions_below
from flexbe_core.engine.engine import ErrorPolicy
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_core.testing import ScriptedState

RUNS = 3000
RUNS_PER_TEST = 250

OUTCOMES = ("x", "y")
BOOM = "boom"
UNDECLARED = "undeclared"
EVENTS = {"enter", "exit", "execute"}
SCRIPT = (None, None, "x", "y", "x", BOOM, UNDECLARED)
PREEMPT = "preempt"
FORCE = "force"


# What is run


@dataclass(frozen=True)
class StateSpec:
    label: str
    script: tuple  # of each execution
    levels: tuple
    enter_fails: tuple  # of each visit, over and over
    exit_fails: tuple


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


def some(rng, choices, least, most):
    return tuple(rng.choice(choices) for _ in range(rng.randint(least, most)))


def random_state(rng, label):
    rarely = (False,) * 7 + (True,)
    levels = tuple(rng.randint(0, 3) for _ in OUTCOMES)
    return StateSpec(
        label,
        some(rng, SCRIPT, 1, 4),
        levels,
        some(rng, rarely, 1, 3),
        exit_fails=some(rng, rarely, 1, 3),
    )


def random_spec(rng, label, depth):
    kind = rng.choice(("state", "machine", "priority", "concurrency")) if depth else "state"
    if kind == "state":
        return random_state(rng, label)
    return random_container(rng, label, depth, kind)


def random_container(rng, label, depth, kind):
    labels = [f"{label}{letter}" for letter in "abc"[: rng.randint(1, 3)]]
    children = tuple(random_spec(rng, name, depth - 1) for name in labels)
    if kind == "concurrency":
        pairs = [(name, outcome) for name in labels for outcome in OUTCOMES]
        conditions = tuple(
            (rng.choice(OUTCOMES), some(rng, pairs, 1, 2)) for _ in range(rng.randint(0, 3))
        )
        return ConcurrencySpec(label, children, conditions)
    targets = {
        (name, outcome): rng.choice([*labels, *OUTCOMES]) for name in labels for outcome in OUTCOMES
    }
    return MachineSpec(label, children, targets, kind == "priority")


def random_command(rng):
    choices = (c.Pause(), c.Resume(), c.Repeat(), c.Lock(""), c.Unlock(""), FORCE, None)
    command = rng.choice(choices)
    return c.SetAutonomy(rng.randint(0, 3)) if command is None else command


def random_orders(rng):
    """Return the commands before each tick; a preempt comes in one run of three, at any moment."""
    orders = [
        [random_command(rng) for _ in range(rng.randint(0, 2))] for _ in range(rng.randint(0, 25))
    ]
    if orders and rng.random() < 0.33:
        rng.choice(orders).append(PREEMPT)
    return orders


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
    counts: dict = field(default_factory=dict)
    paused: bool = False
    locks: set = field(default_factory=set)
    priority: str | None = None
    claim: tuple | None = None

    def fail(self):
        if not self.holds:
            raise FailedError

    def record(self, spec, event, fails=(False,)):
        """Note an event of a state, and return whether it fails."""
        self.trace.append((spec.label, event))
        count = self.counts[spec.label, event] = self.counts.get((spec.label, event), -1) + 1
        if fails[count % len(fails)]:
            self.fail()
            return True
        return False


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
                if world.record(spec, "enter", spec.enter_fails):
                    yield
                    continue
            outcome, stored = stored if stored is not None else forced, None
            if outcome is None:
                world.record(spec, "execute")
                step = world.counts[spec.label, "execute"]
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
                entered = repeat = False
                world.record(spec, "exit", spec.exit_fails)
            elif outcome is not None and not blocked:
                entered = False
                if not world.record(spec, "exit", spec.exit_fails):
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


class FailingState(ScriptedState):
    """A scripted state whose events fail as its specification says."""

    def __init__(self, spec, log):
        script = [ValueError(BOOM) if item == BOOM else item for item in spec.script]
        super().__init__(script, OUTCOMES, log)
        self.spec = spec

    def on_enter(self, userdata):
        super().on_enter(userdata)
        self.fail("enter", self.spec.enter_fails)

    def on_exit(self, userdata):
        super().on_exit(userdata)
        self.fail("exit", self.spec.exit_fails)

    def fail(self, event, fails):
        if fails[(self.log.count((self.name, event)) - 1) % len(fails)]:
            raise ValueError(BOOM)


def build(spec, log):
    if isinstance(spec, StateSpec):
        return FailingState(spec, log)
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


@pytest.mark.parametrize("first_seed", range(0, RUNS, RUNS_PER_TEST))
def test_the_engine_does_what_the_reference_does(bench, first_seed):
    for seed in range(first_seed, first_seed + RUNS_PER_TEST):
        check_run(bench, seed)


def check_run(bench, seed):
    rng = random.Random(seed)
    log = []
    spec = random_container(rng, "r", 3, "machine")
    holds, supervised, level = rng.random() < 0.5, rng.random() < 0.5, rng.randint(0, 4)
    root = build(spec, log)
    engine = bench.engine(root, level, ErrorPolicy.HOLD if holds else ErrorPolicy.FAIL, supervised)
    world = World(holds, level, supervised)
    reference = run_machine(spec, "", world, True)

    end = "runs"
    for tick, batch in enumerate(random_orders(rng)):
        for command in batch:
            order(engine, world, command)
        if PREEMPT in batch:
            break
        end = tick_engine(engine, float(tick))
        assert end == tick_reference(reference), (seed, tick)
        if end != "runs":
            break
        assert [entry for entry in log if entry[1] in EVENTS] == world.trace, (seed, tick)
    if end == "runs":
        engine.handle(c.Preempt())
        assert engine.run(1000.0) == "preempted", seed
        reference.close()
    root.destroy()
    # In which order siblings are exited at the end is not specified.
    assert sorted(entry for entry in log if entry[1] in EVENTS) == sorted(world.trace), seed
    assert engine.priority is None or world.paused, seed
    for state in definitions_below(root):
        if isinstance(state, ScriptedState):
            events = [event for label, event in log if label == state.name]
            assert events.count("enter") == events.count("exit"), (seed, state.path)
            assert events.count("stop") == 1, (seed, state.path)


def order(engine, world, command):
    """Give a command to both; an outcome is forced in the state that is active in the engine."""
    leaf = engine.root.leaf()
    if command == PREEMPT:
        command = c.Preempt()
    if command == FORCE:
        command = c.ForceOutcome(leaf.label if leaf else "none", 1)
    engine.handle(command)
    if isinstance(command, c.Preempt):
        return
    if isinstance(command, c.SetAutonomy):
        world.level = command.level
    elif world.supervised and (leaf is None or leaf.definition._is_controlled):
        world.queue.append(command)
