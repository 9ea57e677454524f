"""Joins Test: random concurrency containers, one behind the other."""

import itertools
import random

from engine_test_behaviors.visited_state import TOPIC, VisitedState
from flexbe_core import Behavior, ConcurrencyContainer, OperatableStateMachine
from flexbe_core.proxy import ProxyPublisher

DEPTH = 2


class JoinsSM(Behavior):
    """Joins Test."""

    def __init__(self):
        super().__init__()
        self.name = "Joins Test"
        self.add_parameter("joins", 40)
        self.add_parameter("seed", 1)

    def create(self):
        self.rng = random.Random(self.seed)
        self.names = itertools.count()
        root = OperatableStateMachine(outcomes=["finished"])
        labels = [f"join{index}" for index in range(self.joins)]
        with root:
            for label, following in zip(labels, [*labels[1:], "last"], strict=True):
                OperatableStateMachine.add(label, self.join(DEPTH), {"done": following})
            OperatableStateMachine.add("last", VisitedState(0), {"done": "finished"})
        ProxyPublisher().wait_for_any(TOPIC)
        return root

    def join(self, depth):
        """Return a container that one of its states ends, or two of them."""
        labels = [f"s{next(self.names)}" for _ in range(self.rng.randint(2, 3))]
        ending = self.rng.sample(labels, self.rng.randint(1, 2))
        conditions = [("done", [(label, "done") for label in ending])]
        container = ConcurrencyContainer(conditions, outcomes=["done"])
        with container:
            for label in labels:
                OperatableStateMachine.add(label, self.child(depth), {"done": "done"})
        return container

    def child(self, depth):
        if depth == 0 or self.rng.random() < 0.4:
            return VisitedState(self.rng.choice([0, 0, 1, 2]))
        if self.rng.random() < 0.5:
            return self.join(depth - 1)
        machine = OperatableStateMachine(outcomes=["done"])
        labels = [f"s{next(self.names)}" for _ in range(self.rng.randint(1, 3))]
        with machine:
            for label, following in zip(labels, [*labels[1:], "done"], strict=True):
                OperatableStateMachine.add(label, self.child(depth - 1), {"done": following})
        return machine
