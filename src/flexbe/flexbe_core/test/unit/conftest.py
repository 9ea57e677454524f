"""Engines for tests, driven by a clock that the test holds."""

import pytest

from flexbe_core.core import ConcurrencyContainer, OperatableStateMachine, PriorityContainer
from flexbe_core.engine.engine import Engine, ErrorPolicy


class Bench:
    """Builds containers and drives them tick by tick.

    Attributes:
        now: [s] what the engine takes for ROS time.
    """

    add = staticmethod(OperatableStateMachine.add)

    def __init__(self):
        self.now = 0.0
        self.log = []

    def machine(self, outcomes=("finished",), kind=OperatableStateMachine, **keys):
        return kind(outcomes=outcomes, **keys)

    def priority(self, outcomes=("finished",), **keys):
        return self.machine(outcomes, PriorityContainer, **keys)

    def concurrency(self, conditions, outcomes=("finished",), **keys):
        return ConcurrencyContainer(conditions, outcomes=outcomes, **keys)

    def around(self, child, label="inner", outcomes=("finished",), **keys):
        """Return a machine that holds a child, and ends with it."""
        machine = self.machine(outcomes, **keys)
        with machine:
            self.add(label, child, dict.fromkeys(child.outcomes, outcomes[0]), {})
        return machine

    def sequence(self, container, *states):
        """Add states one behind the other; the last leads to the container's first outcome."""
        labels = [f"s{index}" for index in range(len(states))]
        targets = [*labels[1:], container.outcomes[0]]
        with container:
            for label, state, target in zip(labels, states, targets, strict=True):
                self.add(label, state, dict.fromkeys(state.outcomes, target), {})
        return container

    def engine(self, root, level=255, policy=ErrorPolicy.AUTO, supervised=False):
        engine = Engine(root, policy)
        engine.supervision = engine.supervision.__class__(autonomy_level=level)
        if supervised:
            root._is_controlled = True
            for state in _supervised(root):
                state._is_controlled = True
        return engine

    def run(self, engine, ticks=100, step_s=1.0):
        """Tick until an outcome comes, advancing the clock each time."""
        for _ in range(ticks):
            outcome = engine.run(self.now)
            self.now += step_s
            if outcome is not None:
                return outcome
        return None


def _supervised(container):
    for state in container._supervised_children():
        yield state
        if hasattr(state, "_supervised_children"):
            yield from _supervised(state)


@pytest.fixture
def bench():
    return Bench()
