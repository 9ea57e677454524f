"""Mirrors follow the real engine through random behaviors with random joins.

After each execution a mirror is where the engine is, and what it publishes on the way is active at
that moment. The messages between them are made of the engine's facts, as its reporter makes them.
"""

import itertools
import random

import pytest

from flexbe_core.core import ConcurrencyContainer, OperatableStateMachine, PriorityContainer
from flexbe_core.engine import commands
from flexbe_core.engine.checksum import checksum
from flexbe_core.engine.concurrency import Concurrency
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.errors import BehaviorFailure
from flexbe_core.engine.facts import Left, Shown, Synced
from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.structure import first_path, structure_of
from flexbe_core.testing import ScriptedState
from flexbe_mirror.core.mirror import Code, Mirror, Show
from flexbe_mirror.core.tree import Part, Tree

RUNS = 1000
RUNS_PER_TEST = 250
TICKS = 40
BEHAVIOR = 7
OUTCOMES = ("x", "y")
SCRIPT = (None, None, "x", "y", "x", ValueError("boom"))
KINDS = (OperatableStateMachine, PriorityContainer, ConcurrencyContainer, ConcurrencyContainer)


def random_container(rng, depth, names, kind=OperatableStateMachine):
    """Return a container; the transitions of a join's states lead out, as the App writes them."""
    labels = [f"s{next(names)}" for _ in range(rng.randint(1, 4))]
    is_join = kind is ConcurrencyContainer
    conditions = [random_condition(rng, labels) for _ in range(rng.randint(1, 3))]
    container = kind(outcomes=OUTCOMES, **({"conditions": conditions} if is_join else {}))
    following = OUTCOMES if is_join else (*labels, *OUTCOMES)
    with container:
        for label in labels:
            child = random_child(rng, depth, names)
            targets = {name: rng.choice(following) for name in OUTCOMES}
            levels = {name: rng.randint(0, 3) for name in OUTCOMES}
            OperatableStateMachine.add(label, child, targets, levels)
    return container


def random_child(rng, depth, names):
    if depth == 0 or rng.random() < 0.4:
        script = [rng.choice(SCRIPT) for _ in range(rng.randint(1, 5))]
        return ScriptedState(script, OUTCOMES)
    return random_container(rng, depth - 1, names, rng.choice(KINDS))


def random_condition(rng, labels):
    pairs = [(label, rng.choice(OUTCOMES)) for label in labels]
    return rng.choice(OUTCOMES), rng.sample(pairs, rng.randint(1, min(2, len(pairs))))


def random_command(rng, engine):
    leaf = engine.root.leaf()
    return rng.choice(
        [
            commands.Sync(),
            commands.Repeat(),
            commands.SetAutonomy(rng.randint(1, 3)),
            commands.Attach(3),
            commands.Pause(),
            commands.Resume(),
            commands.ForceOutcome(leaf.label if leaf else "none", rng.randint(0, 1)),
        ]
    )


class Follower:
    """A mirror, and every path that it has published."""

    def __init__(self, root):
        parts = (
            Part(part.path, part.children, tuple(zip(part.outcomes, part.transitions)))  # noqa: B905
            for part in structure_of(root)
        )
        self.mirror = Mirror()
        self.mirror.on_structure(BEHAVIOR, Tree(parts))
        self.published = []
        self.take(self.mirror.on_status(Code.STARTED.value, BEHAVIOR, (), 0.0))

    def take(self, deeds):
        assert all(isinstance(deed, Show) for deed in deeds), "it knows where the engine is"
        self.published += [deed.path for deed in deeds]

    def follow(self, fact):
        """Take the messages that stock FlexBE publishes too."""
        if isinstance(fact, Left) and fact.is_followed:
            self.take(self.mirror.on_outcome(fact.index))
        elif isinstance(fact, Synced):
            self.take(self.mirror.on_sync(BEHAVIOR, checksum(fact.path)))

    def read(self, fact):
        """Take the message in which this engine names its active state."""
        if isinstance(fact, Shown):
            self.take(self.mirror.on_active_state(fact.path))


def supervise(state):
    state._is_controlled = True
    for child in state._supervised_children() if hasattr(state, "_supervised_children") else ():
        supervise(child)


def execute(engine, now):
    """Execute once; return whether the behavior goes on."""
    try:
        return engine.run(now) is None
    except BehaviorFailure:
        return False


def active_paths(node):
    """Return the states that are active, or that the next execution enters."""
    if isinstance(node, Leaf):
        return {node.path}
    if not node.active:
        return {first_path(node.definition, node.path)}
    if isinstance(node, Concurrency):
        running = [child for label, child in node.children.items() if label not in node.results]
        return set().union(*map(active_paths, running)) if running else {node.path}
    return active_paths(node.current)


def check_run(seed):
    rng = random.Random(seed)
    root = random_container(rng, 3, itertools.count())
    supervise(root)
    engine = Engine(root, rng.choice([ErrorPolicy.HOLD, ErrorPolicy.FAIL]))
    follower, reader = Follower(root), Follower(root)
    for tick in range(TICKS):
        if rng.random() < 0.2:
            engine.handle(random_command(rng, engine))
        before = len(follower.published), len(reader.published)
        goes_on = execute(engine, float(tick))
        for fact in engine.take_facts():
            follower.follow(fact)
            reader.read(fact)
        if not goes_on:
            break
        active = active_paths(engine.root)
        assert set(follower.published[before[0] :]) <= active, (seed, tick)
        assert set(reader.published[before[1] :]) <= active, (seed, tick)
        assert follower.mirror.path == reader.mirror.path, (seed, tick)
        assert reader.mirror.path in active, (seed, tick)


@pytest.mark.parametrize("first_seed", range(0, RUNS, RUNS_PER_TEST))
def test_every_path_that_a_mirror_publishes_is_active(first_seed):
    for seed in range(first_seed, first_seed + RUNS_PER_TEST):
        check_run(seed)
