"""Mirrors follow the real engine through random behaviors with random joins.

What a mirror publishes was active, in the order of the run, and whenever the engine has published,
the mirror is where the engine is. A mirror that only follows what stock FlexBE publishes is there
too, though the outcome of the first state of a join may lead it elsewhere until the sync behind it.

One run of three begins without supervision. The messages are made of the engine's events, as its
reporter makes them.
"""

import itertools
import random

import pytest

from flexbe_core.core import ConcurrencyContainer, OperatableStateMachine, PriorityContainer
from flexbe_core.engine import supervision as commands
from flexbe_core.engine.containers import Concurrency
from flexbe_core.engine.definitions import first_path, structure_of
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.supervision import Left, Shown, StatusCode, Synced, checksum
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_core.testing import ScriptedState
from flexbe_mirror.flexbe_mirror import AskWhere, Mirror, Show, Tree

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

    def __init__(self, engine):
        self.engine = engine
        self.mirror = Mirror()
        self.published = []

    def join(self, is_late):
        """Begin to follow: from the first state, or wherever a running behavior is."""
        parts = structure_of(self.engine.root.definition)
        messages = [
            lambda: self.mirror.on_structure(BEHAVIOR, Tree(parts)),
            lambda: self.mirror.on_status(StatusCode.STARTED, BEHAVIOR, (), 0.0),
        ]
        for message in reversed(messages) if is_late else messages:
            self.take(message())

    def take(self, deeds):
        for deed in deeds:
            if isinstance(deed, Show):
                self.published.append(deed.path)
            else:
                assert deed == AskWhere()
                assert not self.published, "it knows where the engine is"
                self.engine.handle(commands.Sync())

    def follow(self, event):
        """Take the messages that stock FlexBE publishes too."""
        if isinstance(event, Left):
            self.take(self.mirror.on_outcome(event.index))
        elif isinstance(event, Synced):
            self.take(self.mirror.on_sync(BEHAVIOR, checksum(event.path)))

    def read(self, event):
        """Take the message in which this engine names its active state."""
        if isinstance(event, Shown):
            self.take(self.mirror.on_active_state(event.path))


def supervise(state):
    state._is_controlled = True
    for child in state._supervised_children() if hasattr(state, "_supervised_children") else ():
        supervise(child)


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


class Run:
    """A run of a random behavior.

    Attributes:
        moments: the states that were active after each execution since the last check.
    """

    def __init__(self, seed):
        self.rng = random.Random(seed)
        self.root = random_container(self.rng, 3, itertools.count())
        policy = self.rng.choice([ErrorPolicy.HOLD, ErrorPolicy.FAIL])
        self.engine = Engine(self.root, policy)
        self.follower, self.reader = Follower(self.engine), Follower(self.engine)
        self.moments = []
        self.attaches_at = self.rng.choice([0, 0, self.rng.randint(1, 10)])

    def attach(self):
        supervise(self.root)
        for mirror in (self.follower, self.reader):
            mirror.join(is_late=self.attaches_at > 0)
        self.moments = [active_paths(self.engine.root)]

    def execute(self, now):
        """Execute, one time or more; return whether the behavior goes on."""
        try:
            return self.engine.run(now, self.is_enough) is None
        except BehaviorFailure:
            return False
        finally:
            self.moments.append(active_paths(self.engine.root))

    def is_enough(self):
        self.moments.append(active_paths(self.engine.root))
        return self.rng.random() < 0.4

    def check(self):
        """Have the mirrors take what was published, and check what they make of it."""
        before = len(self.reader.published)
        for event in self.engine.take_events():
            self.follower.follow(event)
            self.reader.read(event)
        assert were_active(self.reader.published[before:], self.moments)
        self.moments = self.moments[-1:]

    def check_place(self):
        assert self.follower.mirror.path == self.reader.mirror.path
        assert self.reader.mirror.path in self.moments[-1]


def were_active(paths, moments):
    """Return whether the paths were active, each not before the one before it."""
    moment = iter(moments)
    active = next(moment)
    for path in paths:
        while path not in active:
            active = next(moment, None)
            if active is None:
                return False
    return True


def check_run(seed):
    run = Run(seed)
    for tick in range(TICKS):
        if tick == run.attaches_at:
            run.attach()
        if run.rng.random() < 0.2:
            run.engine.handle(random_command(run.rng, run.engine))
        goes_on = run.execute(float(tick))
        run.check()
        if not goes_on:
            break
        if tick >= run.attaches_at:
            run.check_place()


@pytest.mark.parametrize("first_seed", range(0, RUNS, RUNS_PER_TEST))
def test_every_path_that_a_mirror_publishes_was_active(first_seed):
    for seed in range(first_seed, first_seed + RUNS_PER_TEST):
        try:
            check_run(seed)
        except AssertionError as error:
            raise AssertionError(f"in run {seed}") from error
