"""State machines in a run: order of events, nesting, userdata, errors."""

import pytest

from flexbe_core.core import EventState, OperatableStateMachine, StateMachine
from flexbe_core.core.exceptions import StateError, StateMachineError, UserDataError
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.supervision import Entered, Preempt, Raised
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_core.testing import ScriptedState


def never():
    return False


def test_events_come_in_their_order(bench):
    state = ScriptedState([None, "done"])
    engine = bench.engine(bench.sequence(bench.machine(), state))
    assert bench.run(engine) == "finished"
    assert [event for _, event in state.log] == ["enter", "execute", "execute", "exit"]


def test_states_that_return_at_once_run_without_delay(bench):
    states = [ScriptedState() for _ in range(100)]
    engine = bench.engine(bench.sequence(bench.machine(), *states))
    assert engine.run(0.0, never) == "finished"


def test_one_tick_executes_one_state(bench):
    log = []
    states = [ScriptedState(log=log), ScriptedState(log=log)]
    engine = bench.engine(bench.sequence(bench.machine(), *states))
    assert engine.run(0.0) is None
    assert {label for label, _ in log} == {"s0"}


def test_a_state_that_waits_is_due_after_its_period(bench):
    state = ScriptedState([None])
    state.set_rate(20)
    engine = bench.engine(bench.sequence(bench.machine(), state))
    engine.run(10.0)
    assert engine.next_due() == pytest.approx(10.05)
    engine.run(10.06)
    assert engine.next_due() == pytest.approx(10.10), "the beat is kept"
    engine.run(10.50)
    assert engine.next_due() == pytest.approx(10.55), "a missed beat is not made up for"


def test_a_woken_state_is_due_at_once(bench):
    engine = bench.engine(bench.sequence(bench.machine(), ScriptedState([None])))
    engine.run(10.0)
    engine.wake(engine.executing)
    assert engine.next_due() < 10.0


@pytest.mark.parametrize("alarm", [10.03, 17.5])
def test_an_alarm_takes_the_place_of_the_next_poll(bench, alarm):
    engine = bench.engine(bench.sequence(bench.machine(), ScriptedState([None])))
    engine.run(9.95)
    engine.executing.alarm = alarm
    engine.run(10.0)
    assert engine.next_due() == alarm
    engine.run(alarm)
    assert engine.next_due() == pytest.approx(alarm + 0.1), "an alarm rings once"


def test_an_alarm_in_the_past_is_no_busy_loop(bench):
    engine = bench.engine(bench.sequence(bench.machine(), ScriptedState([None])))
    engine.run(10.0)
    engine.executing.alarm = 9.0
    engine.run(10.0)
    assert engine.next_due() == pytest.approx(10.1)


def test_an_outcome_of_a_nested_container_is_taken_in_the_same_tick(bench):
    inner = bench.sequence(bench.machine(), ScriptedState())
    assert bench.engine(bench.around(inner)).run(0.0) == "finished"


def test_a_container_can_be_visited_again(bench):
    inner_state = ScriptedState()
    inner = bench.sequence(bench.machine(), inner_state)
    root = bench.machine()
    with root:
        bench.add("inner", inner, {"finished": "again"}, {})
        bench.add(
            "again", ScriptedState(["yes", "no"], ["yes", "no"]), {"yes": "inner", "no": "finished"}
        )
    assert bench.run(bench.engine(root)) == "finished"
    assert [event for _, event in inner_state.log].count("enter") == 2


def test_entries_are_reported_with_paths_from_the_root(bench):
    inner = bench.sequence(bench.machine(), ScriptedState())
    engine = bench.engine(bench.around(inner, "box"))
    engine.run(0.0)
    assert engine.take_events() == [Entered("/box/s0")]


def test_of_a_long_series_of_entries_only_the_last_is_reported(bench):
    engine = bench.engine(bench.sequence(bench.machine(), *[ScriptedState() for _ in range(50)]))
    engine.run(0.0, never)
    assert engine.take_events() == [Entered("/s49")]


def test_a_slow_cycle_is_put_back_to_its_rate_and_freed_by_a_wait(bench):
    log = []
    root = bench.machine()
    with root:
        bench.add("a", ScriptedState(["b"] * 30 + [None, "b"], ["b"], log=log), {"b": "b"})
        bench.add("b", ScriptedState(["a"], ["a"], log=log), {"a": "a"})
    engine = bench.engine(root)
    engine.run(0.0)
    engine.slow = True
    engine.run(0.0, never)
    assert len([entry for entry in log if entry[1] == "enter"]) == 4, (
        "each once more, then both wait"
    )
    assert engine.next_due() == pytest.approx(0.1)
    engine.slow = False
    entries = []
    for tick in range(1, 60):
        before = len(log)
        engine.run(0.1 * tick, lambda: len(log) > 2000)
        entries.append(len([entry for entry in log[before:] if entry[1] == "enter"]))
        if entries[-1] > 2:
            break
    assert entries[-1] > 2, "a state that returned None ended it"
    assert set(entries[:-1]) <= {0, 1, 2}


def test_a_long_chain_is_not_taken_for_a_cycle(bench):
    engine = bench.engine(bench.sequence(bench.machine(), *[ScriptedState() for _ in range(300)]))
    engine.slow = True
    assert engine.run(0.0, never) == "finished"


# Errors


@pytest.mark.parametrize(
    "script", [[ValueError("no camera")], ["undeclared"]], ids=["raises", "undeclared"]
)
def test_unsupervised_an_error_ends_the_run_and_exits_the_state(bench, script):
    state = ScriptedState(script)
    engine = bench.engine(bench.sequence(bench.machine(), state))
    with pytest.raises(BehaviorFailure, match="/s0"):
        bench.run(engine)
    engine.stop()
    assert [event for _, event in state.log] == ["enter", "execute", "exit"]


def test_an_undeclared_outcome_names_the_declared_ones(bench):
    engine = bench.engine(bench.sequence(bench.machine(), ScriptedState(["oops"], ["a", "b"])))
    with pytest.raises(
        BehaviorFailure, match="returned 'oops'; outcomes with a transition: 'a', 'b'"
    ):
        bench.run(engine)


@pytest.mark.parametrize(
    "script", [[ValueError("no camera"), "done"], ["oops", "done"]], ids=["raises", "undeclared"]
)
def test_supervised_a_state_that_fails_is_held_and_tried_again(bench, script):
    state = ScriptedState(script)
    machine = bench.sequence(bench.machine(), state)
    engine = bench.engine(machine, level=3)
    assert engine.run(0.0) is None
    assert isinstance(engine.root.last_exception, ValueError | StateError)
    assert engine.next_due() == pytest.approx(0.1)
    (raised,) = [event for event in engine.take_events() if isinstance(event, Raised)]
    assert (raised.path, raised.held) == ("/s0", True)
    assert engine.run(1.0) == "finished"
    assert [event for _, event in state.log] == ["enter", "execute", "execute", "exit"]


def test_the_policy_may_hold_an_unsupervised_state(bench):
    engine = bench.engine(
        bench.sequence(bench.machine(), ScriptedState([ValueError(), "done"])),
        policy=ErrorPolicy.HOLD,
    )
    assert bench.run(engine) == "finished"


def test_the_policy_may_end_a_supervised_run(bench):
    engine = bench.engine(
        bench.sequence(bench.machine(), ScriptedState([ValueError()])),
        level=3,
        policy=ErrorPolicy.FAIL,
    )
    with pytest.raises(BehaviorFailure):
        bench.run(engine)


def test_a_failing_on_exit_ends_the_visit_all_the_same(bench):
    class Failing(ScriptedState):
        def on_exit(self, userdata):
            super().on_exit(userdata)
            raise ValueError("stuck")

    state = Failing()
    engine = bench.engine(bench.sequence(bench.machine(), state))
    with pytest.raises(BehaviorFailure, match="stuck"):
        bench.run(engine)
    engine.stop()
    assert [event for _, event in state.log] == ["enter", "execute", "exit"]


def test_a_class_that_holds_no_errors_passes_them_on():
    machine = StateMachine(outcomes=["finished"])
    with machine:
        StateMachine.add("a", ScriptedState([ValueError("plain")]), {"done": "finished"})
    with pytest.raises(ValueError, match="plain"):
        Engine(machine).run(0.0)


def test_an_outcome_of_a_container_without_transition_is_an_error(bench):
    inner = bench.sequence(bench.machine(["finished", "other"]), ScriptedState())
    root = bench.machine()
    with root:
        bench.add("inner", inner, {"other": "finished"}, {})
    with pytest.raises(BehaviorFailure, match="ended with 'finished'"):
        bench.run(bench.engine(root))


def test_transitions_that_lead_nowhere_are_found_on_entry(bench):
    root = bench.machine()
    with root:
        bench.add("a", ScriptedState(), {"done": "nowhere"}, {})
    with pytest.raises(StateMachineError, match=r"'a': 'done' -> 'nowhere'.*'a', 'finished'"):
        bench.engine(root).run(0.0)


def test_a_nested_container_that_cannot_begin_is_held_by_its_parent(bench):
    engine = bench.engine(bench.around(bench.machine()), level=3)
    assert engine.run(0.0) is None
    assert isinstance(engine.root.last_exception, StateMachineError)
    assert engine.next_due() == pytest.approx(0.1)


def test_an_empty_root_is_an_error(bench):
    with pytest.raises(StateMachineError, match="has no states"):
        bench.engine(bench.machine()).run(0.0)


# Preempt


def test_preempt_exits_what_is_active_and_nothing_else(bench):
    log = []
    inner = bench.sequence(bench.machine(), ScriptedState([None], log=log))
    root = bench.machine()
    with root:
        bench.add("inner", inner, {"finished": "later"}, {})
        bench.add("later", ScriptedState(log=log), {"done": "finished"}, {})
    engine = bench.engine(root)
    engine.run(0.0)
    engine.handle(Preempt())
    assert engine.run(0.0) == "preempted"
    assert log == [("s0", "enter"), ("s0", "execute"), ("s0", "exit")]


def test_a_state_that_is_preempted_before_it_began_is_not_entered(bench):
    state = ScriptedState()
    engine = bench.engine(bench.sequence(bench.machine(), state))
    engine.handle(Preempt())
    assert engine.run(0.0) == "preempted"
    assert state.log == []


def test_a_state_that_returns_preempted_itself_ends_everything(bench):
    root = bench.machine()
    with root:
        bench.add("a", ScriptedState(["preempted"]), {"done": "finished"}, {})
    assert bench.run(bench.engine(root)) == "preempted"


def test_adding_a_state_leaves_the_callers_transitions_alone(bench):
    transitions = {"done": "finished"}
    with bench.machine():
        bench.add("a", ScriptedState(), transitions, {})
    assert transitions == {"done": "finished"}


# Userdata


class Increment(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"], input_keys=["number"], output_keys=["number"])

    def execute(self, userdata):
        userdata.number += 1
        return "done"


def test_data_flows_through_remappings_into_the_container_and_out(bench):
    inner = OperatableStateMachine(outcomes=["finished"], input_keys=["n"], output_keys=["n"])
    with inner:
        bench.add("one", Increment(), {"done": "two"}, {}, remapping={"number": "n"})
        bench.add("two", Increment(), {"done": "finished"}, {}, remapping={"number": "n"})
    root = OperatableStateMachine(outcomes=["finished"], output_keys=["total"])
    root.userdata.total = 40
    with root:
        bench.add("inner", inner, {"finished": "finished"}, {}, remapping={"n": "total"})
    engine = bench.engine(root)
    assert bench.run(engine) == "finished"
    assert engine.root.userdata.total == 42


def test_default_data_of_a_nested_container_shadows_the_parents(bench):
    class Read(EventState):
        def __init__(self):
            super().__init__(outcomes=["done"], input_keys=["x"], output_keys=["seen"])

        def execute(self, userdata):
            userdata.seen = userdata.x
            return "done"

    inner = OperatableStateMachine(outcomes=["finished"], input_keys=["x"], output_keys=["seen"])
    inner.userdata.x = "inner"
    with inner:
        bench.add("read", Read(), {"done": "finished"}, {})
    root = bench.around(inner)
    root.userdata.x = "outer"
    engine = bench.engine(root)
    bench.run(engine)
    assert engine.root.userdata["seen"] == "inner"


def test_an_input_changed_in_place_is_an_error_of_that_state(bench):
    class Vandal(EventState):
        def __init__(self):
            super().__init__(outcomes=["done"], input_keys=["values"])

        def execute(self, userdata):
            userdata.values.append(1)
            return "done"

    root = bench.around(Vandal(), "vandal")
    root.userdata.values = []
    with pytest.raises(BehaviorFailure) as caught:
        bench.run(bench.engine(root))
    assert isinstance(caught.value.cause, UserDataError)
    assert caught.value.path == "/vandal"


def test_on_exit_sees_the_runtime_data_also_on_preempt(bench):
    seen = []

    class Reader(EventState):
        def __init__(self):
            super().__init__(outcomes=["done"], input_keys=["x"])

        def on_exit(self, userdata):
            seen.append(userdata.x)

    inner = bench.sequence(
        OperatableStateMachine(outcomes=["finished"], input_keys=["x"]), Reader()
    )
    root = bench.around(inner)
    root.userdata.x = 5
    engine = bench.engine(root)
    engine.run(0.0)
    engine.handle(Preempt())
    engine.run(0.0)
    assert seen == [5]


# Building


def test_labels_are_unique_and_no_outcomes(bench):
    with bench.machine():
        bench.add("a", ScriptedState(), {"done": "finished"}, {})
        with pytest.raises(StateMachineError, match="has a state 'a' already"):
            bench.add("a", ScriptedState(), {"done": "finished"}, {})
        with pytest.raises(StateMachineError, match="'finished' is an outcome"):
            bench.add("finished", ScriptedState(), {"done": "finished"}, {})


def test_states_are_added_inside_with_only(bench):
    with pytest.raises(StateMachineError, match="no container is open"):
        bench.add("a", ScriptedState(), {"done": "finished"}, {})


def test_a_state_belongs_to_one_container(bench):
    state = ScriptedState()
    with bench.machine():
        bench.add("a", state, {"done": "finished"}, {})
    with bench.machine(), pytest.raises(StateError, match="make another instance"):
        bench.add("b", state, {"done": "finished"}, {})


def test_containers_can_be_opened_inside_each_other(bench):
    outer, inner = bench.machine(), bench.machine()
    with outer:
        with inner:
            bench.add("a", ScriptedState(), {"done": "finished"}, {})
        bench.add("inner", inner, {"finished": "finished"}, {})
    assert list(outer) == ["inner"]
    assert "a" in inner
    assert inner["a"].path == "/inner/a"


def test_names_given_as_one_string_are_refused():
    with pytest.raises(TypeError, match="outcomes must be a list"):
        ScriptedState(outcomes="done")
    with pytest.raises(TypeError, match="input_keys must be a list"):
        OperatableStateMachine(input_keys="x")


def test_repeated_names_count_once_in_order():
    class Keys(EventState):
        def __init__(self):
            super().__init__(outcomes=("b", "a", "b"), io_keys=["x"], input_keys=("y", "x"))

    state = Keys()
    assert (state.outcomes, state.input_keys, state.output_keys) == (["b", "a"], ["y", "x"], ["x"])
