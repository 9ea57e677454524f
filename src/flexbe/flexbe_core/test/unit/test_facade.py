"""What states may rely on: names, hooks, and the attributes that are theirs to use."""

import flexbe_core
import flexbe_core.core
import flexbe_core.proxy
from flexbe_core import EventState, OperatableStateMachine
from flexbe_core.core import (
    LockableState,
    ManuallyTransitionableState,
    OperatableState,
    PreemptableState,
    RosState,
    State,
)
from flexbe_core.engine.definitions import DEFAULT_PERIOD_S, Part, period_s, structure_of
from flexbe_core.testing import ScriptedState

# Contract 8.2: what stock FlexBE claims on a state, which users know to avoid.
STOCK_ATTRIBUTES = {
    *("_outcomes", "_input_keys", "_output_keys", "_name", "_parent", "_rate", "_is_controlled"),
    *("_pub", "_sub", "_force_transition", "_locked", "_stored_outcome", "_entering", "_skipped"),
    *("_last_requested_outcome", "_paused", "_last_active_container", "_feedback_topic"),
    *("_transition_topic", "_lock_topic", "_unlock_topic", "_preempt_topic", "_outcome_topic"),
    *("_request_topic", "_debug_topic", "_repeat_topic", "_pause_topic"),
    *("_enable_ros_control", "_disable_ros_control", "_preempted_name"),
}


def test_states_keep_every_other_attribute_for_themselves():
    claimed = {name for name in dir(EventState(outcomes=["done"])) if name.startswith("_")}
    own = {name for name in claimed if not name.startswith("__") and "__" not in name}
    assert own <= STOCK_ATTRIBUTES


def test_the_hierarchy_is_stocks():
    chain = [EventState, OperatableState, PreemptableState, LockableState]
    chain += [ManuallyTransitionableState, RosState, State, object]
    assert list(EventState.__mro__) == chain


def test_modules_are_where_stock_has_them():
    import importlib

    for name in flexbe_core.core.__all__:
        words = "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
        assert hasattr(importlib.import_module(f"flexbe_core.core.{words}"), name)


def test_generated_behaviors_find_their_six_names():
    names = "Behavior Autonomy OperatableStateMachine ConcurrencyContainer PriorityContainer Logger"
    assert all(hasattr(flexbe_core, name) for name in names.split())


def test_outcomes_may_be_changed_after_construction_as_stock_states_do():
    state = EventState(outcomes=["a"])
    state._outcomes = ["b"]
    assert state.outcomes == ["b"]


def test_a_rate_is_set_in_hertz_or_as_rospy_does():
    state = EventState(outcomes=["a"])
    assert period_s(state._rate) == DEFAULT_PERIOD_S
    state.set_rate(50)
    assert period_s(state._rate) == 0.02

    class RospyRate:
        class sleep_dur:  # noqa: N801 - rospy's name
            @staticmethod
            def to_sec():
                return 0.5

    assert period_s(RospyRate()) == 0.5
    assert period_s("a user's own attribute") == DEFAULT_PERIOD_S


def test_the_structure_lists_containers_before_their_children():
    inner = OperatableStateMachine(outcomes=["ok"])
    with inner:
        OperatableStateMachine.add(
            "a", ScriptedState(outcomes=["x", "y"]), {"x": "ok", "y": "a"}, {"x": 1, "y": 2}
        )
    root = OperatableStateMachine(outcomes=["end"])
    with root:
        OperatableStateMachine.add("box", inner, {"ok": "end"})
    assert structure_of(root) == (
        Part("", ("box",), ("end",), (), autonomy=()),
        Part("/box", ("a",), ("ok",), ("end",), autonomy=(0,)),
        Part("/box/a", (), ("x", "y"), ("ok", "a"), autonomy=(1, 2)),
    )
