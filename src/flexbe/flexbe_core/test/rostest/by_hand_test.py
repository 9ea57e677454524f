#!/usr/bin/env python3
"""States and containers executed by hand, as tests of states do, and driven to their end."""

import threading
import time
import unittest

import rospy
import rostest
from flexbe_msgs.msg import CommandFeedback, OutcomeRequest
from std_msgs.msg import Bool, Empty, String, UInt8

from flexbe_core import (
    ConcurrencyContainer,
    EventState,
    OperatableStateMachine,
    PriorityContainer,
)
from flexbe_core.core import PreemptableState, UserData
from flexbe_core.core.exceptions import StateMachineError, UserDataError
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_core.proxy import ProxySubscriberCached
from flexbe_core.testing import ScriptedState, wait_until

LIMIT_S = 90.0
CYCLE_S = 120.0  # of a state that nothing but a message wakes
FEEDBACK = "flexbe/command_feedback"


def one_state(state, outcome="done"):
    machine = OperatableStateMachine(outcomes=["finished"])
    with machine:
        OperatableStateMachine.add("a", state, {outcome: "finished"}, {outcome: 1})
    return machine


class ByHandTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.feedback = ProxySubscriberCached()
        cls.feedback.subscribe(FEEDBACK, CommandFeedback, buffered=True)
        EventState(outcomes=["done"])._enable_ros_control()  # advertises
        rospy.sleep(0.3)

    def setUp(self):
        self.feedback.remove_last_msg(FEEDBACK, clear_buffer=True)

    def assert_feedback(self, command, *args):
        self.assertTrue(wait_until(lambda: self.feedback.has_buffered(FEEDBACK)), command)
        message = self.feedback.get_from_buffer(FEEDBACK)
        self.assertEqual((message.command, tuple(message.args)), (command, args))

    def controlled(self, script=(None,), outcomes=("done", "failed")):
        state = ScriptedState(script, outcomes)
        state.set_name("mine")
        state._enable_ros_control()
        return state

    def command(self, state, topic, message):
        state._sub._callback(message, f"flexbe/command/{topic}")
        return state.execute(UserData())

    # A single state

    def test_a_lone_state_runs_with_its_events(self):
        state = ScriptedState([None, "done"])
        state.set_rate(20)
        data = UserData()
        self.assertIsNone(state.execute(data))
        begin = time.monotonic()
        state.sleep()
        self.assertGreater(time.monotonic() - begin, 0.03)
        self.assertEqual(state.execute(data), "done")
        self.assertEqual([e for _, e in state.log], ["enter", "execute", "execute", "exit"])

    def test_a_lone_state_keeps_the_callers_userdata(self):
        class Sum(EventState):
            def __init__(self):
                super().__init__(outcomes=["done"], input_keys=["x"], output_keys=["y"])

            def execute(self, userdata):
                userdata.y = userdata.x + 1
                return "done"

        data = UserData()
        data.x = 4
        self.assertEqual(Sum().execute(data), "done")
        self.assertEqual((data.x, data.y), (4, 5))

    def test_a_lone_state_sleeps_to_its_beat_whether_or_not_it_is_executed(self):
        state = ScriptedState()
        begin = time.monotonic()
        for _ in range(3):
            state.sleep()
        self.assertGreater(time.monotonic() - begin, 0.27)
        self.assertLessEqual(state.sleep_duration, 0.1)
        state.set_rate(20)
        self.assertLessEqual(state.sleep_duration, 0.05)

    def test_an_error_of_a_lone_state_is_the_callers(self):
        with self.assertRaisesRegex(ValueError, "no"):
            ScriptedState([ValueError("no")]).execute(UserData())

    def test_a_controlled_state_applies_commands(self):
        state = self.controlled()
        self.assertIsNone(self.command(state, "pause", Bool(True)))
        self.assert_feedback("pause")
        self.assertIsNone(self.command(state, "pause", Bool(False)))
        self.assert_feedback("resume")
        self.assertIsNone(self.command(state, "repeat", Empty()))
        self.assert_feedback("repeat")
        self.assertEqual(self.command(state, "transition", OutcomeRequest(1, "mine")), "failed")
        self.assert_feedback("transition", "mine", "mine")
        events = [event for _, event in state.log]
        self.assertEqual(
            events,
            ["pause", "enter", "resume", "execute", "execute", "exit", "enter", "exit"],
        )

    def test_a_controlled_state_is_preempted(self):
        state = self.controlled()
        self.assertIsNone(state.execute(UserData()))
        self.assertEqual(self.command(state, "preempt", Empty()), "preempted")
        self.assert_feedback("preempt")
        self.assertIsNone(state.execute(UserData()), "once")

    def test_stocks_flag_preempts_what_is_executed_by_hand(self):
        state = ScriptedState([None])
        PreemptableState.preempt = True
        self.assertEqual(state.execute(UserData()), "preempted")
        ScriptedState()
        self.assertFalse(PreemptableState.preempt, "constructing a state sets it back")
        self.assertIsNone(state.execute(UserData()))

    def test_a_locked_state_keeps_its_outcome(self):
        state = self.controlled(["done"])
        self.assertIsNone(self.command(state, "lock", String("")))
        self.assertTrue(state.is_locked())
        self.assertEqual(self.command(state, "unlock", String("")), "done")
        self.assertFalse(state.is_locked())

    def test_a_lock_that_comes_before_the_first_execution_holds(self):
        state = ScriptedState(["done"])
        machine = one_state(state)
        state._enable_ros_control()
        state._sub._callback(String("/a"), "flexbe/command/lock")
        self.assertIsNone(machine.execute(None))
        self.assertTrue(state._locked)
        self.assert_feedback("lock", "/a", "/a")
        state._sub._callback(String("/a"), "flexbe/command/unlock")
        self.assertEqual(machine.execute(None), "finished")

    def test_a_state_that_is_added_after_operators_may_supervise_it_gets_commands(self):
        """In the order of stock FlexBE's own tests, in each kind of container, also in two."""
        join = [("finished", [("a", "done")])]
        for kind, arguments in (
            (OperatableStateMachine, {}),
            (PriorityContainer, {}),
            (ConcurrencyContainer, {"conditions": join}),
        ):
            container = self.supervised_then_added(kind, **arguments)
            self.lock_and_unlock(container, container["a"])
        inner = self.supervised_then_added(OperatableStateMachine)
        outer = OperatableStateMachine(outcomes=["finished"])
        with outer:
            OperatableStateMachine.add("inner", inner, {"finished": "finished"})
        self.lock_and_unlock(outer, inner["a"])

    def supervised_then_added(self, kind, **arguments):
        state = ScriptedState(["done"])
        state._enable_ros_control()
        container = kind(outcomes=["finished"], **arguments)
        with container:
            OperatableStateMachine.add("a", state, {"done": "finished"}, {"done": -1})
        return container

    def lock_and_unlock(self, machine, state):
        state._sub._callback(String(state.path), "flexbe/command/lock")
        self.assertIsNone(machine.execute(UserData()), machine)
        self.assert_feedback("lock", state.path, state.path)
        state._sub._callback(String(state.path), "flexbe/command/unlock")
        self.assertEqual(machine.execute(UserData()), "finished", machine)
        self.assert_feedback("unlock", state.path, state.path)

    def test_a_container_may_be_locked_from_code(self):
        state = ScriptedState(["done"])
        machine = one_state(state)
        state._enable_ros_control()
        machine._locked = True
        self.assertIsNone(machine.execute(None))
        self.assertTrue(machine.is_locked() and machine.is_locked_inside())
        self.assertIs(machine.get_locked_state(), machine)
        self.assertFalse(machine.transition_allowed("a", "done"))
        self.assertTrue(machine.unlock(""))
        self.assertFalse(machine.lock("/nowhere"))
        self.assertTrue(machine.transition_allowed("a", "done"))
        self.assertEqual(machine.execute(None), "finished")

    def test_breakpoints_follow_their_parameter(self):
        state = ScriptedState()
        one_state(state)._enable_ros_control()
        rospy.set_param("/flexbe/breakpoints", ["/a"])
        self.assertTrue(wait_until(lambda: state.is_breakpoint))
        rospy.set_param("/flexbe/breakpoints", [])
        self.assertTrue(wait_until(lambda: not state.is_breakpoint))

    # Containers

    def test_a_machine_is_executed_step_by_step(self):
        machine = one_state(ScriptedState([None, "done"]))
        with self.assertRaises(StateMachineError):
            machine.current_state  # noqa: B018
        self.assertIsNone(machine.execute(None))
        self.assertEqual(machine.current_state_label, "a")
        self.assertIs(machine.get_deep_state(), machine["a"])
        self.assertEqual(machine.execute(None), "finished")
        self.assertIsNone(machine.get_deep_state())

    def test_userdata_goes_in_and_out(self):
        class Twice(EventState):
            def __init__(self):
                super().__init__(outcomes=["done"], io_keys=["x"])

            def execute(self, userdata):
                userdata.x *= 2
                return "done"

        machine = one_state(Twice())
        data = UserData()
        data.x = 4
        self.assertEqual(machine.execute(data), "finished")
        self.assertEqual(data.x, 8)

    def test_a_held_error_can_be_to_check(self):
        machine = one_state(ScriptedState([UserDataError("what"), None]))
        machine.autonomy_level = 255
        self.assertIsNone(machine.execute(None))
        self.assertIsInstance(machine._last_exception, UserDataError)
        self.assertIsNone(machine.execute(None))
        self.assertIsNone(machine._last_exception)

    def test_the_level_of_the_class_is_the_default_of_each_machine(self):
        OperatableStateMachine.autonomy_level = 1
        try:
            machine = one_state(ScriptedState())
            machine._enable_ros_control()
            self.assertFalse(machine.is_transition_allowed("a", "done"))
            self.assertIsNone(machine.execute(None))
            self.assertEqual(machine.get_required_autonomy("done"), 1)
            machine._sub._callback(UInt8(2), "flexbe/command/autonomy")
            self.assertEqual(machine.execute(None), "finished")
            self.assertEqual(machine.autonomy_level, 2)
            self.assertEqual(OperatableStateMachine.autonomy_level, 1)
        finally:
            OperatableStateMachine.autonomy_level = 3

    def test_an_uncontrolled_machine_is_preempted_without_feedback(self):
        machine = one_state(ScriptedState([None]))
        self.assertIsNone(machine.execute(None))
        machine._sub._callback(Empty(), "flexbe/command/preempt")
        self.assertEqual(machine.execute(None), "preempted")
        self.assertFalse(self.feedback.has_buffered(FEEDBACK))

    def test_a_preempt_that_comes_before_the_first_execution_holds(self):
        machine = one_state(ScriptedState([None]))
        machine._sub._callback(Empty(), "flexbe/command/preempt")
        self.assertEqual(machine.execute(None), "preempted")
        self.assertIsNone(machine.execute(None), "once")
        machine = one_state(ScriptedState([None]))
        self.assertIsNone(machine.execute(None), "it came before the machine was made")
        machine = one_state(ScriptedState([None]))
        machine._sub._callback(Empty(), "flexbe/command/preempt")
        thread, found = self.spin(machine)
        thread.join(LIMIT_S)
        self.assertEqual(found, ["preempted"])

    def test_a_lock_from_code_before_the_first_execution_holds(self):
        state = ScriptedState(["done"])
        machine = one_state(state)
        machine._locked = True
        state._is_controlled = True
        self.assertIsNone(machine.execute(None))
        self.assertTrue(machine.is_locked())

    def test_the_attributes_of_stock_states(self):
        state = ScriptedState([None, "done"])
        machine = one_state(state)
        self.assertTrue(state._entering)
        machine.execute(None)
        self.assertFalse(state._entering)
        state._entering = True
        state._enable_ros_control()
        state._locked = True
        self.assertIsNone(machine.execute(None))
        self.assertEqual(state._stored_outcome, "done")
        state._stored_outcome = None
        self.assertIsNone(machine.execute(None))
        self.assertEqual(state._stored_outcome, "done", "it was executed again")
        state._locked = False
        self.assertEqual(machine.execute(None), "finished")
        self.assertIsNone(state._stored_outcome)
        events = [event for _, event in state.log]
        self.assertEqual(events, ["enter", "execute", "enter", "execute", "execute", "exit"])

    def test_a_concurrency_container_names_what_has_ended(self):
        container = ConcurrencyContainer([("end", [("b", "done")])], outcomes=["end"])
        with container:
            OperatableStateMachine.add("a", ScriptedState(), {"done": "end"})
            OperatableStateMachine.add("b", ScriptedState([None, "done"]), {"done": "end"})
        self.assertEqual(container._returned_outcomes, {})
        container.execute(None)
        self.assertEqual(container._returned_outcomes, {"a": "done"})

    def test_the_children_of_a_concurrency_container_keep_their_rates(self):
        fast, slow = ScriptedState([None]), ScriptedState([None])
        fast.set_rate(50)
        container = ConcurrencyContainer([("end", [("a", "done")])], outcomes=["end"])
        with container:
            OperatableStateMachine.add("a", fast, {"done": "end"})
            OperatableStateMachine.add("b", slow, {"done": "end"})

        def run_half_a_second():
            """Return whether the fast one was executed three times as often as the slow one."""
            fast.log.clear()
            slow.log.clear()
            end = time.monotonic() + 0.5
            while time.monotonic() < end:
                container.execute(None)
                container.sleep()
            counts = (fast.log.count(("a", "execute")), slow.log.count(("b", "execute")))
            return counts[0] > 3 * counts[1] > 0

        self.assertTrue(wait_until(run_half_a_second), "not once, even if the machine is busy")

    def test_a_rate_of_a_tests_own_has_every_execution_execute_the_state(self):
        class Always:
            def remaining(self):
                return rospy.Duration(0)

        state = ScriptedState([None])
        container = ConcurrencyContainer([("end", [("a", "done")])], outcomes=["end"])
        with container:
            OperatableStateMachine.add("a", state, {"done": "end"})
        container.execute(None)
        container.execute(None)
        self.assertEqual(state.log.count(("a", "execute")), 1)
        state._rate = Always()
        container.execute(None)
        container.execute(None)
        self.assertEqual(state.log.count(("a", "execute")), 3)

    def test_a_part_of_a_behavior_can_be_executed_by_itself(self):
        inner = one_state(ScriptedState([None, "done"]))
        outer = OperatableStateMachine(outcomes=["ended"])
        with outer:
            OperatableStateMachine.add("box", inner, {"finished": "ended"})
        self.assertIsNone(inner.execute(None))
        self.assertEqual(inner.current_state_label, "a")
        self.assertIs(inner.get_deep_state(), inner["a"])
        self.assertEqual(inner.execute(None), "finished")

    def test_a_priority_container_is_named_by_its_class(self):
        alone = PriorityContainer(outcomes=["finished"])
        with alone:
            OperatableStateMachine.add("a", ScriptedState([None, "done"]), {"done": "finished"})
        machine = OperatableStateMachine(outcomes=["ended"])
        with machine:
            OperatableStateMachine.add("alone", alone, {"finished": "ended"})
        self.assertIsNone(machine.execute(None))
        self.assertEqual(PriorityContainer.active_container, "/alone")
        self.assertEqual(machine.execute(None), "ended")
        self.assertIsNone(PriorityContainer.active_container)

    def test_what_is_assigned_to_the_class_runs_alone(self):
        container = ConcurrencyContainer([("end", [("b", "done")])], outcomes=["end"])
        states = {"a": ScriptedState([None]), "b": ScriptedState([None])}
        with container:
            for label, state in states.items():
                state.set_rate(10_000)
                OperatableStateMachine.add(label, state, {"done": "end"})
        PriorityContainer.active_container = "/b"
        for _ in range(2):
            container.execute(None)
            time.sleep(0.001)  # a period
        self.assertEqual(PriorityContainer.active_container, "/b")
        PriorityContainer.active_container = None
        self.assertNotIn(("a", "enter"), states["a"].log)
        container.execute(None)
        self.assertIn(("a", "enter"), states["a"].log)
        self.assertIsNone(PriorityContainer.active_container)

    def test_waiting_for_a_condition(self):
        machine = one_state(ScriptedState())
        begin = time.monotonic()
        machine.wait(seconds=0.05, condition=lambda: time.monotonic() - begin > 0.1)
        self.assertGreater(time.monotonic() - begin, 0.1)

    # Driven to the end

    def spin(self, machine):
        """Drive a machine in a thread; return the thread and where it puts the outcome."""
        found = []

        def drive():
            try:
                found.append(machine.spin())
            except Exception as error:  # noqa: BLE001 - the test looks at it
                found.append(error)

        thread = threading.Thread(target=drive, daemon=True)
        thread.start()
        return thread, found

    def test_a_preempt_ends_a_spin_at_once(self):
        state = ScriptedState([None])
        state.set_rate(1.0 / CYCLE_S)
        machine = one_state(state)
        thread, found = self.spin(machine)
        self.assertTrue(wait_until(lambda: ("a", "execute") in state.log))
        begin = time.monotonic()
        machine._sub._callback(Empty(), "flexbe/command/preempt")
        thread.join(LIMIT_S)
        self.assertLess(time.monotonic() - begin, CYCLE_S / 2, "it waited for its cycle")
        self.assertEqual(found, ["preempted"])
        self.assertEqual(state.log.count(("a", "exit")), 1)
        thread, found = self.spin(one_state(ScriptedState()))
        thread.join(LIMIT_S)
        self.assertEqual(found, ["finished"])

    def test_a_message_wakes_only_the_state_that_asked_for_it(self):
        class Asking(ScriptedState):
            def execute(self, userdata):
                super().execute(userdata)
                return "done" if self._sub.has_msg("by_hand/asked") else None

        ProxySubscriberCached({"by_hand/asked": String, "by_hand/other": String})
        state = Asking()
        state.set_rate(1.0 / CYCLE_S)
        machine = one_state(state)
        thread, found = self.spin(machine)
        self.assertTrue(wait_until(lambda: ("a", "execute") in state.log))
        for _ in range(20):
            state._sub._callback(String(), "by_hand/other")
        time.sleep(0.1)  # nothing is what must happen
        self.assertEqual(state.log.count(("a", "execute")), 1)
        state._sub._callback(String(), "by_hand/asked")
        thread.join(CYCLE_S / 2)
        self.assertEqual(found, ["finished"])

    def test_a_flood_of_messages_does_not_take_the_core(self):
        class Asking(ScriptedState):
            def execute(self, userdata):
                super().execute(userdata)
                self._sub.has_msg("by_hand/flood")

        ProxySubscriberCached({"by_hand/flood": String})
        state = Asking()
        machine = one_state(state)
        thread, found = self.spin(machine)
        begin = time.monotonic()
        while time.monotonic() < begin + 0.5:
            state._sub._callback(String(), "by_hand/flood")
            time.sleep(0.0002)
        executed, took = state.log.count(("a", "execute")), time.monotonic() - begin
        machine._sub._callback(Empty(), "flexbe/command/preempt")
        thread.join(LIMIT_S)
        self.assertEqual(found, ["preempted"])
        self.assertLess(executed, 800 * took, "more often than each 2 ms and a few ahead")
        self.assertGreater(executed, 5)

    def test_a_cycle_that_never_waits_is_slowed_down_and_can_be_stopped(self):
        machine = OperatableStateMachine(outcomes=["finished"])
        states = [ScriptedState(["next"], ["next"]) for _ in range(2)]
        with machine:
            OperatableStateMachine.add("a", states[0], {"next": "b"})
            OperatableStateMachine.add("b", states[1], {"next": "a"})
        thread, found = self.spin(machine)

        def is_slow():
            before, begin = len(states[0].log), time.monotonic()
            time.sleep(0.5)
            return len(states[0].log) - before < 80 * (time.monotonic() - begin)

        self.assertTrue(wait_until(is_slow), "about 10 Hz, once it has run free")
        machine._sub._callback(Empty(), "flexbe/command/preempt")
        thread.join(LIMIT_S)
        self.assertEqual(found, ["preempted"])

    def test_an_unsupervised_error_ends_a_spin_and_exits_the_state(self):
        state = ScriptedState([ValueError("no")])
        machine = one_state(state)
        machine.autonomy_level = 255
        thread, found = self.spin(machine)
        thread.join(LIMIT_S)
        self.assertIsInstance(found[0], BehaviorFailure)
        self.assertEqual(state.log[-1], ("a", "exit"))

    def test_all_states_are_started_and_stopped(self):
        log = []
        inner = one_state(ScriptedState(log=log))
        machine = OperatableStateMachine(outcomes=["finished"])
        with machine:
            OperatableStateMachine.add("inner", inner, {"finished": "finished"})
            OperatableStateMachine.add("never", ScriptedState(log=log), {"done": "finished"})
        machine.confirm("By Hand", 5)
        self.assertEqual(log, [("a", "start"), ("never", "start")])
        self.assertEqual(machine.spin(), "finished")
        machine.destroy()
        self.assertEqual(log[-2:], [("a", "stop"), ("never", "stop")])

    def test_a_failing_on_stop_stops_no_other(self):
        class Failing(ScriptedState):
            def on_stop(self):
                super().on_stop()
                raise ValueError("stuck")

        log = []
        machine = OperatableStateMachine(outcomes=["finished"])
        with machine:
            OperatableStateMachine.add("a", Failing(log=log), {"done": "b"})
            OperatableStateMachine.add("b", ScriptedState(log=log), {"done": "finished"})
        machine.confirm("By Hand", 5)
        with self.assertRaisesRegex(ValueError, "stuck"):
            machine.destroy()
        self.assertEqual(log[-2:], [("a", "stop"), ("b", "stop")])

    def test_a_failing_on_start_stops_what_was_started(self):
        class Failing(ScriptedState):
            def on_start(self):
                raise ValueError("no start")

        state = Failing()
        with self.assertRaisesRegex(ValueError, "no start"):
            one_state(state).confirm("By Hand", 5)
        self.assertEqual(state.log, [("a", "stop")])


if __name__ == "__main__":
    rospy.init_node("test_by_hand")
    rostest.rosrun("flexbe_core", "test_by_hand", ByHandTest)
