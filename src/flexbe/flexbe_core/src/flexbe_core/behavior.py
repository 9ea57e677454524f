"""A behavior, as users define it: a root container, parameters, and autonomy levels."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import yaml

from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.core.state import State
from flexbe_core.engine.definitions import Kind, definition_at, first_path, structure_of
from flexbe_core.engine.engine import ErrorPolicy, MigratingState
from flexbe_core.engine.supervision import DEFAULT_AUTONOMY, Preempt, Release
from flexbe_core.engine.user_data import StateMachineError
from flexbe_core.logger import Logger
from flexbe_core.ros.session import own_session

# Attributes of every behavior that are not parameters.
_NO_PARAMETERS = frozenset({"name", "id", "contains", "requested_state_path"})


class Autonomy:
    """How much a transition needs.

    A transition is taken without asking if its level is below the behavior's.
    """

    Inherit = 0
    Off = 0
    Low = 1
    High = 2
    Full = 3


class Behavior:
    """The base of all behaviors; override `create`."""

    def __init__(self) -> None:
        self.name = "unnamed behavior"
        self.id = 0
        self.contains: dict[str, Behavior] = {}
        self.requested_state_path: str | None = None
        self._state_machine: OperatableStateMachine | None = None
        self._behaviors: dict[str, Behavior] = {}
        self._autonomy_level = DEFAULT_AUTONOMY
        self._debug = False
        self._on_error = ErrorPolicy.AUTO
        self._migrating: MigratingState | None = None

    def create(self) -> OperatableStateMachine:
        """Build and return the root container; parameters have their final values."""
        raise NotImplementedError(f"behavior {self.name!r} does not define create()")

    def add_parameter(self, name: str, default: object) -> None:
        """Declare a parameter; its value is an attribute."""
        setattr(self, name, default)

    def add_behavior(self, behavior_class: type[Behavior], behavior_id: str) -> None:
        """Declare a contained behavior; its id is its path without the leading slash."""
        self.contains[behavior_id] = behavior_class()

    def use_behavior(
        self,
        behavior_class: type[Behavior],
        behavior_id: str,
        default_keys: Collection[str] | None = None,
        parameters: Mapping[str, Any] | None = None,
    ) -> OperatableStateMachine | None:
        """Build a contained behavior and return its container, to be added.

        Args:
            behavior_class: its class, for readers of the code.
            behavior_id: the id under which it was declared.
            default_keys: input keys for which it uses its own default values.
            parameters: values that win over those set at the start.
        """
        behavior = self.contains.get(behavior_id)
        if behavior is None:
            declared = ", ".join(self.contains) or "none"
            Logger.logerr(
                "behavior %s uses %r without add_behavior; declared: %s",
                *(self.name, behavior_id, declared),
            )
            return None
        for name, value in (parameters or {}).items():
            setattr(behavior, name, value)
        container = behavior._get_state_machine()
        container._input_keys = [k for k in container._input_keys if k not in (default_keys or ())]
        for key in container._input_keys:
            container.userdata(remove_key=key)
        return container

    def set_up(
        self,
        id: int,
        autonomy_level: int,
        debug: bool,
        on_error: ErrorPolicy = ErrorPolicy.AUTO,
    ) -> None:
        """Store what the start request says.

        Args:
            id: checksum of the source.
            autonomy_level: 255 to run without supervision.
            debug: kept, unused.
            on_error: what happens when a state raises.
        """
        self.id = id
        self._autonomy_level = autonomy_level
        self._debug = debug
        self._on_error = on_error

    def prepare_for_execution(self, input_data: Mapping[str, Any] | None = None) -> None:
        """Build the behavior and set its inputs; warn about keys that it does not have."""
        self._state_machine = self.create()
        self._state_machine.autonomy_level = self._autonomy_level
        own_session(self._state_machine).engine.policy = self._on_error
        known = {*self._state_machine._input_keys, *self._state_machine.userdata._data}
        for key, value in (input_data or {}).items():
            if key in known:
                self._state_machine.userdata[key] = value
            else:
                Logger.logwarn(
                    "behavior %s has no input %r; it has: %s",
                    *(self.name, key, ", ".join(sorted(known)) or "none"),
                )

    def set_parameter(self, name: str, value: object) -> bool:
        """Set a parameter here and in contained behaviors.

        Args:
            name: `key` or `/key` sets it in all behaviors, `/path/key` in those at or below path.
            value: what to set; text is converted to the type of the parameter's present value.

        Returns:
            whether any behavior has the parameter.

        Raises:
            ValueError: if the value cannot be converted.
        """
        path, _, key = name.rpartition("/")
        found = False
        for at, behavior in {"": self, **self.get_contained_behaviors()}.items():
            is_meant = at == path or at.startswith(f"{path}/") or not path
            if is_meant and behavior._has_parameter(key):
                found = True
                try:
                    behavior._set_typed_attribute(key, value)
                except ValueError as error:
                    raise ValueError(f"parameter {name!r} {error}") from error
        return found

    def confirm(self) -> None:
        """Begin: listen to operators and start all states."""
        self._prepared().confirm(self.name, self.id, self._migrating)

    def prepare_for_switch(self, state: State) -> None:
        """Attach the active state of another version; it continues here, locked, under its path.

        Raises:
            StateMachineError: if there is no state at its path here.
        """
        self.attach_state(MigratingState(state.path, state, entered=True, userdata={}))

    def attach_state(self, migrating: MigratingState) -> None:
        """Attach the active state of another version, with the userdata of its containers.

        Raises:
            StateMachineError: if there is no state at its path here.
        """
        state: State = migrating.state
        container: Any = self._prepared()
        *labels, label = migrating.path.split("/")[1:]
        for name in labels:
            container = container[name] if name in getattr(container, "_labels", ()) else None
        found = getattr(container, "_labels", {}).get(label)
        if found is None or type(found).__kind__ is not Kind.STATE:
            raise StateMachineError(
                f"this version of {self.name!r} has no state {migrating.path!r}, which is active"
            )
        state._disable_ros_control()
        if state.parent is not None:
            former: Any = state.parent
            former.remove_state(state)
        container.replace_state(state)
        self.requested_state_path = migrating.path
        self._migrating = migrating

    def start_at(self, path: str, userdata: Mapping[str, Any]) -> None:
        """Begin at a state in place of the first one, as a debugger does; call it once prepared.

        Args:
            path: of the state, or of a container, which begins with its first state.
            userdata: values such as earlier states would write, by the keys of the behavior; those
                of a container around the state by its path and key, `/Place/socket_pose`.

        Raises:
            StateMachineError: if there is no such state, or no such container around it.
        """
        root = self._prepared()
        try:
            found = definition_at(root, path) if path.startswith("/") else None
        except (KeyError, AttributeError):
            found = None
        if found is None:
            paths = (part.path for part in structure_of(root) if part.path and not part.children)
            raise StateMachineError(
                f"{self.name!r} has no state {path!r} to start at; it has: {', '.join(paths)}"
            )
        path = first_path(found, path)
        state: Any = definition_at(root, path)
        values: dict[str, dict[str, Any]] = {}
        for key, value in userdata.items():
            container, _, name = key.rpartition("/")
            if container and not path.startswith(f"{container}/"):
                raise StateMachineError(
                    f"{key!r} is no value for a start at {path!r}: {container!r} is not around it"
                )
            values.setdefault(container, {})[name] = value
        self._migrating = MigratingState(path, state, entered=False, userdata=values, is_new=True)

    def execute(self) -> str:
        """Run to the end and stop all states.

        Returns:
            the outcome.

        Raises:
            BehaviorFailure: if a state could not continue and no operator supervises the behavior.
            Exception: what an on_stop raised.
        """
        machine = self._prepared()
        try:
            return machine.spin()
        finally:
            machine.destroy()

    def release(self, offer: Callable[[MigratingState | None], bool]) -> None:
        """Detach the active state and end the run if `offer` accepts it, see Release."""
        own_session(self._prepared()).post(Release(offer))

    def preempt(self) -> None:
        """Stop as soon as possible; may be called from any thread."""
        if self._state_machine is not None:
            own_session(self._state_machine).post(Preempt())

    def get_userdata(self) -> dict[str, dict[str, Any]]:
        """Return the runtime userdata of all containers reached so far, by their paths."""
        return own_session(self._state_machine).userdata() if self._state_machine else {}

    def get_execution(self) -> tuple[str, float] | None:
        """Return the path of the state that is being executed, and since when by time.monotonic.

        None between executions.
        """
        return own_session(self._state_machine).execution() if self._state_machine else None

    def get_current_state(self) -> State | None:
        """Return the active state, None if there is none."""
        return self._state_machine.get_deep_state() if self._state_machine else None

    def get_locked_state(self) -> State | None:
        """Return the active state, or else the innermost container around it, that is locked."""
        return self._state_machine.get_locked_state() if self._state_machine else None

    def get_contained_behaviors(self) -> dict[str, Behavior]:
        """Return all contained behaviors, however deep, by their paths."""
        found = {}
        for behavior_id, behavior in self.contains.items():
            found[f"/{behavior_id}"] = behavior
            for path, inner in behavior.get_contained_behaviors().items():
                found[f"/{behavior_id}{path}"] = inner
        return found

    def _prepared(self) -> OperatableStateMachine:
        if self._state_machine is None:
            raise StateMachineError(
                f"behavior {self.name!r} is not built yet; call prepare_for_execution() first"
            )
        return self._state_machine

    def _get_state_machine(self) -> OperatableStateMachine:
        if self._state_machine is None:
            self._state_machine = self.create()
        return self._state_machine

    def _set_typed_attribute(self, name: str, value: object) -> None:
        setattr(self, name, _converted(value, getattr(self, name)))

    def _has_parameter(self, key: str) -> bool:
        return key in vars(self) and not key.startswith("_") and key not in _NO_PARAMETERS


def paired(keys: Sequence[str], values: Sequence[str]) -> list[tuple[str, str]]:
    """Return the keys of a request with their values; empty keys are skipped.

    Raises:
        ValueError: if a key has no value, or a value no key.
    """
    if len(keys) != len(values):
        found = f"{len(values)} values for {len(keys)} keys ({', '.join(keys)})"
        raise ValueError(f"the request has {found}; each key needs one")
    return [(key, value) for key, value in zip(keys, values, strict=True) if key]


def _converted(value: Any, present: object) -> object:  # noqa: ANN401 - of a request
    """Return the value in the type of the present value, if that is a number, boolean or dict."""
    kind = type(present)
    if isinstance(value, kind) or kind not in (bool, int, float, dict):
        return value
    try:
        if kind is bool:
            return str(value).strip().lower() not in ("0", "false")
        if kind is not dict:
            return kind(value)
        loaded = yaml.safe_load(value)
        if isinstance(loaded, dict):
            return loaded
    except (ValueError, TypeError, yaml.YAMLError) as error:
        raise ValueError(_misfit(value, kind)) from error
    raise ValueError(_misfit(value, kind))


def _misfit(value: object, kind: type) -> str:
    return f"takes a value of type {kind.__name__}, found {value!r}"
