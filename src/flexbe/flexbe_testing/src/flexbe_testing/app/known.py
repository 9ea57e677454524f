"""The states and behaviors that the App knows, and which of them a name means."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from functools import cached_property

from flexbe_testing.app.behavior import BehaviorDefinition
from flexbe_testing.app.states import FromParameter, StateDefinition


class Known:
    """What the App found in the packages of a workspace."""

    def __init__(
        self,
        states: Iterable[StateDefinition] = (),
        behaviors: Iterable[BehaviorDefinition] = (),
    ) -> None:
        """Know these states and behaviors, in this order."""
        self.states = tuple(states)
        self.behaviors = tuple(behaviors)

    def behavior(self, class_name: str) -> BehaviorDefinition | None:
        """Return the behavior of a class."""
        return next((b for b in self.behaviors if b.class_name == class_name), None)

    def state(self, alias: str, used: Collection[str]) -> StateDefinition | None:
        """Return the state of a name in a file: `Class`, or `package__Class`.

        Args:
            alias: the name.
            used: outcomes, without blanks, which distinguish states of one class name.
        """
        package, separator, name = alias.partition("__")
        if separator:
            found = [s for s in self.states if (s.package, s.class_name) == (package, name)]
            return found[0] if found else None
        found = [s for s in self.states if s.class_name == alias]
        covering = [s for s in found if _covers(s, used)] if len(found) > 1 else found
        return covering[0] if covering else None

    def alias(self, state: StateDefinition) -> str:
        """Return the name that the App gives to a state when it saves a behavior."""
        is_unique = self._counts[state.class_name] == 1
        return state.class_name if is_unique else f"{state.package}__{state.class_name}"

    @cached_property
    def _counts(self) -> Counter[str]:
        return Counter(state.class_name for state in self.states)


def _covers(state: StateDefinition, used: Collection[str]) -> bool:
    return isinstance(state.outcomes, FromParameter) or set(used) <= set(state.outcomes)
