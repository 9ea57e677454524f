"""A state, as users define it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

from flexbe_core.engine.definitions import Kind, Rate
from flexbe_core.engine.user_data import StateError, UserData


class State:
    """Outcomes, userdata keys, a name, a place in a container, and events to override.

    All events may be overridden, and none has to be. Underscore attributes are those of stock
    FlexBE, which users know to avoid; everything else of a run is kept by the engine.
    """

    __kind__: ClassVar[Kind] = Kind.STATE

    # The run in which the state is the root, made by flexbe_core.ros.session when there is one.
    __session__: Any = None

    _rate: object = Rate()
    _is_controlled = False

    def __init__(
        self,
        *args: object,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
        **kwargs: object,
    ) -> None:
        """Declare outcomes and userdata keys; everything else is ignored, as in stock FlexBE.

        Args:
            args: ignored.
            outcomes: what execute may return.
            input_keys: userdata that the state reads.
            output_keys: userdata that the state writes.
            io_keys: userdata that the state reads and writes.
            kwargs: ignored.

        Raises:
            TypeError: if one of them is a single string.
        """
        io = _names(io_keys, "io_keys")
        self._outcomes = _names(outcomes, "outcomes")
        self._input_keys = _names([*_names(input_keys, "input_keys"), *io], "input_keys")
        self._output_keys = _names([*_names(output_keys, "output_keys"), *io], "output_keys")
        self._name: str | None = None
        self._parent: State | None = None

    @property
    def outcomes(self) -> list[str]:
        """What execute may return."""
        return self._outcomes

    @property
    def input_keys(self) -> list[str]:
        """Userdata that the state reads."""
        return self._input_keys

    @property
    def output_keys(self) -> list[str]:
        """Userdata that the state writes."""
        return self._output_keys

    @property
    def name(self) -> str | None:
        """The label under which the state was added to its container."""
        return self._name

    def set_name(self, value: str) -> None:
        """Name the state, once.

        Raises:
            StateError: if it has a name.
        """
        if self._name is not None:
            raise StateError(f"cannot name a state {value!r}: it is named {self._name!r} already")
        self._name = value

    @property
    def parent(self) -> State | None:
        """The container of the state."""
        return self._parent

    def set_parent(self, value: State) -> None:
        """Put the state into a container, once.

        Raises:
            StateError: if it is in one.
        """
        if self._parent is not None:
            raise StateError(
                f"cannot add state {self._name!r} to {value.name!r}: it is in "
                f"{self._parent.name!r} already; make another instance of it"
            )
        self._parent = value

    @property
    def path(self) -> str:
        """The labels from the root container, which is left out, down to the state."""
        return "" if self._parent is None else f"{self._parent.path}/{self._name}"

    @property
    def sleep_duration(self) -> float:
        """How long sleep would sleep [s]."""
        return 0.0

    def sleep(self) -> None:
        """Wait until the state wants to be executed again."""

    def execute(self, userdata: UserData) -> str | None:
        """Do a little of the work; return an outcome when it is done, None until then."""
        return None

    def _enable_ros_control(self) -> None:
        """Let operators supervise the state."""
        self._is_controlled = True

    def _disable_ros_control(self) -> None:
        """Let the state run by itself."""
        self._is_controlled = False

    def on_start(self) -> None:
        """Prepare, when the behavior begins, whether or not the state will be reached."""

    def on_stop(self) -> None:
        """Clean up, when the behavior ends, however it ends."""

    def on_enter(self, userdata: UserData) -> None:
        """Begin, before the first execute of a visit."""

    def on_exit(self, userdata: UserData) -> None:
        """End, after the last execute of a visit, once per on_enter however the visit ends."""

    def on_pause(self) -> None:
        """Stop for a while."""

    def on_resume(self, userdata: UserData) -> None:
        """Go on after a pause."""


def _names(values: Iterable[str], what: str) -> list[str]:
    """Return the values without repetitions, in order."""
    if isinstance(values, str):
        raise TypeError(f"{what} must be a list of names, found the single string {values!r}")
    return list(dict.fromkeys(values))
