"""The active state of a running behavior migrates to another version of it."""

import pytest

from flexbe_core import Behavior, EventState
from flexbe_core.core import ConcurrencyContainer, OperatableStateMachine
from flexbe_core.engine.engine import Engine, attach_state
from flexbe_core.engine.supervision import Answered, Pause, Preempt, Release, Unlock
from flexbe_core.engine.user_data import StateMachineError
from flexbe_core.testing import ScriptedState


class Write(EventState):
    def __init__(self, value):
        super().__init__(outcomes=["done"], output_keys=["out"])
        self._value = value

    def execute(self, userdata):
        userdata.out = self._value
        return "done"


class Read(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"], input_keys=["part"])
        self.seen = None

    def execute(self, userdata):
        self.seen = userdata.part
        return "done"


class Version(Behavior):
    """Write, then a box with Work and Read."""

    def __init__(self, log, labels=("Work", "Read"), box=OperatableStateMachine, **box_keys):
        super().__init__()
        self.name = "Version"
        self._log, self._labels, self._box, self._box_keys = log, labels, box, box_keys

    def create(self):
        box = self._box(outcomes=["ok"], input_keys=["part"], **self._box_keys)
        work, read = self._labels
        with box:
            OperatableStateMachine.add(work, ScriptedState([None], log=self._log), {"done": read})
            OperatableStateMachine.add(read, Read(), {"done": "ok"})
        root = OperatableStateMachine(outcomes=["finished"])
        root.userdata.part = "default"
        with root:
            OperatableStateMachine.add(
                "Write", Write("A7"), {"done": "Box"}, remapping={"out": "part"}
            )
            OperatableStateMachine.add("Box", box, {"ok": "finished"})
        return root


def prepared(behavior):
    behavior.prepare_for_execution()
    return behavior


def running(bench, behavior):
    engine = bench.engine(prepared(behavior)._state_machine, level=3, supervised=True)
    assert bench.run(engine, ticks=3) is None
    return engine


def switch(engine, version):
    """Hand over to another version; return its engine, or None if it did not take over."""
    offered = []

    def offer(migrating):
        try:
            version.attach_state(migrating)
        except StateMachineError as error:
            offered.append(error)
            return False
        offered.append(migrating)
        return True

    engine.handle(Release(offer))
    if isinstance(offered[0], Exception):
        return None
    successor = Engine(version._state_machine)
    attach_state(successor, offered[0])
    return successor


def test_the_active_state_goes_on_with_its_visit_and_its_userdata(bench):
    log = []
    engine = running(bench, Version(log))
    work = engine.root.leaf().definition
    version = prepared(Version(log))
    successor = switch(engine, version)
    assert bench.run(engine) == "preempted"
    assert Answered("preempt") not in engine.take_events()
    assert successor.root.leaf().definition is work
    assert work.parent is version._state_machine["Box"]
    assert successor.supervision.locks == {"/Box/Work"}
    work._script = ["done"]
    assert bench.run(successor) == "finished"
    assert version._state_machine["Box"]["Read"].seen == "A7", "runtime userdata, not the default"
    assert [event for _, event in log].count("enter") == 1
    assert [event for _, event in log].count("exit") == 1


def test_it_stays_locked_until_an_operator_unlocks_it(bench):
    engine = running(bench, Version([]))
    successor = switch(engine, prepared(Version([])))
    work = successor.root.leaf().definition
    work._is_controlled = True
    work._script = ["done"]
    assert bench.run(successor, ticks=5) is None
    successor.handle(Unlock(""))
    assert bench.run(successor) == "finished"


@pytest.mark.parametrize("is_supervised", [True, False])
def test_a_paused_run_goes_on_paused_if_it_is_supervised(bench, is_supervised):
    log = []
    engine = running(bench, Version(log))
    engine.handle(Pause())
    bench.run(engine, ticks=2)
    version, detached = prepared(Version(log)), []
    engine.handle(Release(lambda migrating: not detached.append(migrating)))
    version.attach_state(detached[0])
    successor = Engine(version._state_machine)
    detached[0].state._is_controlled = is_supervised
    attach_state(successor, detached[0])
    log.clear()
    assert bench.run(successor, ticks=3) is None
    assert (("Work", "execute") in log) != is_supervised
    assert ("Work", "pause") not in log, "it was called before the migration"
    assert (("Work", "resume") in log) != is_supervised


def test_a_version_without_the_state_is_not_switched_to(bench):
    log = []
    engine = running(bench, Version(log))
    assert switch(engine, prepared(Version(log, labels=("Other", "Read")))) is None
    assert bench.run(engine, ticks=5) is None
    assert log[-1] == ("Work", "execute")


def test_a_state_in_the_first_place_of_a_concurrency_container_goes_on(bench):
    def version():
        return Version([], box=ConcurrencyContainer, conditions=[("ok", [("Work", "done")])])

    engine = running(bench, version())
    successor = switch(engine, prepared(version()))
    assert successor.root.leaf().path == "/Box/Work"
    successor.root.leaf().definition._script = ["done"]
    assert bench.run(successor) == "finished"


def test_before_anything_is_active_there_is_nothing_to_hand_over():
    engine = Engine(prepared(Version([]))._state_machine)
    offered = []
    engine.handle(Release(lambda migrating: offered.append(migrating)))
    assert offered == [None]
    assert not engine.supervision.preempt


def test_a_behavior_that_is_being_stopped_does_not_migrate(bench):
    engine = running(bench, Version([]))
    offered = []
    engine.handle(Preempt())
    engine.handle(Release(lambda migrating: offered.append(migrating)))
    assert offered == [None]
    assert bench.run(engine) == "preempted"


def test_stocks_way_to_prepare_keeps_the_state(bench):
    engine = running(bench, Version([]))
    version = prepared(Version([]))
    version.prepare_for_switch(engine.root.leaf().definition)
    assert version.requested_state_path == "/Box/Work"
    with pytest.raises(StateMachineError, match="has no state '/Box/Work'"):
        prepared(Version([], labels=("Other", "Read"))).prepare_for_switch(
            version._state_machine["Box"]["Work"]
        )


def started(path, values):
    behavior = prepared(Version([]))
    behavior.start_at(path, values)
    engine = Engine(behavior._state_machine)
    attach_state(engine, behavior._migrating)
    return engine


def test_a_behavior_begins_at_a_state_in_a_container_with_given_userdata():
    engine = started("/Box/Read", {"part": "given"})
    assert engine.root.leaf().path == "/Box/Read"
    assert engine.root.leaf().entered is False, "on_enter comes with the first execution"
    assert engine.supervision.locks == frozenset()
    assert engine.root.userdata["part"] == "given"


def test_a_container_around_the_state_gets_its_own_values():
    engine = started("/Box/Read", {"part": "given", "/Box/part": "written inside"})
    assert engine.root.userdata["part"] == "given"
    assert engine.root.leaf().parent.userdata["part"] == "written inside"
    for key in ("/Bo/part", "/Box/Read/part", "/Write/part"):
        with pytest.raises(StateMachineError, match="is not around it"):
            started("/Box/Read", {key: 1})


def test_a_container_is_started_at_its_first_state():
    engine = started("/Box", {})
    assert engine.root.leaf().path == "/Box/Work"
    assert engine.root.userdata["part"] == "default"


@pytest.mark.parametrize("path", ["/Nowhere", "/Box/Nowhere", "/Write/Inside", "", "Box"])
def test_a_state_that_does_not_exist_is_refused_with_those_that_do(path):
    with pytest.raises(StateMachineError, match="it has: /Write, /Box/Work, /Box/Read"):
        started(path, {})
