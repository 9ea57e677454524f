"""The state classes and behaviors that charts can name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from flexbe_synthesizer.core.library.signature import BehaviorClass, StateClass, Unreadable


def no_text(_behavior: BehaviorClass) -> str:
    """Return the text of the file of a behavior that has none."""
    return ""


@dataclass(frozen=True)
class Library:
    """What was found on the ROS package path, the unusable with the reason.

    Attributes:
        error_names: error codes by the names of codes and of classes of codes.
        text_of: returns the text of a behavior's file, empty if it cannot be read.
    """

    states: tuple[StateClass, ...] = ()
    behaviors: tuple[BehaviorClass, ...] = ()
    unreadable_states: tuple[Unreadable, ...] = ()
    unreadable_behaviors: tuple[Unreadable, ...] = ()
    error_names: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    text_of: Callable[[BehaviorClass], str] = field(default=no_text, compare=False, repr=False)

    def find_states(self, name: str) -> tuple[StateClass | Unreadable, ...]:
        """Return the state classes that `Class`, `package__Class` or `package/Class` means."""
        return self._states_by_name.get(name, ())

    @cached_property
    def _states_by_name(self) -> Mapping[str, tuple[StateClass | Unreadable, ...]]:
        found: dict[str, tuple[StateClass | Unreadable, ...]] = {}
        known: tuple[StateClass | Unreadable, ...] = (*self.states, *self.unreadable_states)
        for state in known:
            package, name = state.package, state.name
            for spelling in (name, f"{package}__{name}", f"{package}/{name}"):
                found[spelling] = (*found.get(spelling, ()), state)
        return found

    def find_behaviors(self, name: str) -> tuple[BehaviorClass | Unreadable, ...]:
        """Return the behaviors of that display name, else those of that class."""
        known: tuple[BehaviorClass | Unreadable, ...] = (
            *self.behaviors,
            *self.unreadable_behaviors,
        )
        return tuple(b for b in known if b.name == name) or tuple(
            b for b in known if b.class_name == name
        )

    def with_behaviors(self, behaviors: Iterable[BehaviorClass]) -> Library:
        """Return the library with these behaviors in place of those of the same module."""
        new = tuple(behaviors)
        modules = {behavior.module for behavior in new}
        names = {(behavior.package, behavior.name) for behavior in new}
        return replace(
            self,
            behaviors=(*(b for b in self.behaviors if b.module not in modules), *new),
            unreadable_behaviors=tuple(
                b for b in self.unreadable_behaviors if (b.package, b.name) not in names
            ),
        )
