"""Concurrency and priority containers, and what supervision does to siblings."""

import pytest

from flexbe_core.engine.supervision import Entered, Left, Pause, Preempt, Resume, Shown, Synced
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_core.testing import ScriptedState


def events(log, label):
    return [event for name, event in log if name == label]


def both(bench, first, second, conditions=None):
    conditions = conditions or [("finished", [("a", "done"), ("b", "done")])]
    container = bench.concurrency(conditions)
    with container:
        for label, state in (("a", first), ("b", second)):
            bench.add(label, state, dict.fromkeys(state.outcomes, "finished"), {"done": 0})
    return container


def test_it_ends_when_a_condition_is_satisfied(bench):
    log = []
    container = both(bench, ScriptedState([None, "done"], log=log), ScriptedState(log=log))
    assert bench.run(bench.engine(container)) == "finished"
    assert events(log, "a") == ["enter", "execute", "execute", "exit"]
    assert events(log, "b") == ["enter", "execute", "exit"]


def test_conditions_are_to_check_in_order(bench):
    container = bench.concurrency(
        [("second", [("b", "done")]), ("first", [("a", "done")])], outcomes=["first", "second"]
    )
    with container:
        bench.add("a", ScriptedState(), {"done": "first"}, {})
        bench.add("b", ScriptedState(), {"done": "second"}, {})
    assert bench.run(bench.engine(container)) == "second"


def test_children_that_still_run_are_exited_once_and_the_others_not_again(bench):
    log = []
    inner = bench.concurrency([("finished", [("x", "done")])])
    with inner:
        bench.add("y", ScriptedState(["done"], log=log), {"done": "finished"}, {})
        bench.add("x", ScriptedState([None], log=log), {"done": "finished"}, {})
    outer = both(
        bench,
        bench.around(inner, outcomes=["done"]),
        ScriptedState([None, None, "done"], log=log),
        [("finished", [("b", "done")])],
    )
    assert bench.run(bench.engine(outer)) == "finished"
    for label in ("x", "y"):
        assert events(log, label).count("exit") == 1


def test_each_child_keeps_its_own_rate(bench):
    fast, slow = ScriptedState([None]), ScriptedState([None])
    fast.set_rate(50)
    slow.set_rate(10)
    engine = bench.engine(both(bench, fast, slow))
    now = 0.0
    while now < 1.0:
        engine.run(now)
        now = max(engine.next_due(), now + 1e-4)
    assert 48 <= events(fast.log, "a").count("execute") <= 52
    assert 9 <= events(slow.log, "b").count("execute") <= 11


def test_a_preempted_child_ends_it_at_once(bench):
    log = []
    container = both(bench, ScriptedState(["preempted"], log=log), ScriptedState([None], log=log))
    engine = bench.engine(container)
    assert bench.run(engine) == "preempted"
    assert events(log, "b") in ([], ["enter", "execute", "exit"])


def test_preempt_exits_all_children(bench):
    log = []
    engine = bench.engine(
        both(bench, ScriptedState([None], log=log), ScriptedState([None], log=log))
    )
    engine.run(0.0)
    engine.handle(Preempt())
    assert engine.run(0.0) == "preempted"
    for label in ("a", "b"):
        assert events(log, label) == ["enter", "execute", "exit"]


def test_all_children_ended_without_a_condition_is_an_error_that_names_the_outcomes(bench):
    container = both(bench, ScriptedState(), ScriptedState(), [("finished", [("a", "other")])])
    with pytest.raises(BehaviorFailure, match="a: done, b: done"):
        bench.run(bench.engine(bench.around(container)))


def test_a_held_child_does_not_stop_its_siblings(bench):
    log = []
    failing = ScriptedState([ValueError("again"), ValueError("again"), "done"], log=log)
    container = both(bench, failing, ScriptedState([None, "done"], log=log))
    assert bench.run(bench.engine(container, level=3)) == "finished"
    assert events(log, "a").count("execute") == 3


def test_only_the_first_child_is_supervised_and_shown(bench):
    container = both(bench, ScriptedState([None, "done"]), ScriptedState([None, "done"]))
    engine = bench.engine(container, level=3, supervised=True)
    assert bench.run(engine) == "finished"
    events = engine.take_events()
    assert [event.path for event in events if isinstance(event, Entered)] == ["/a"]
    assert [event.path for event in events if isinstance(event, Left)] == ["/a"]


def test_after_its_first_state_has_ended_another_is_shown_also_without_supervision(bench):
    container = both(bench, ScriptedState(), ScriptedState([None, None, "done"]))
    engine = bench.engine(container)
    shown = []
    for now in range(2):
        engine.run(float(now))
        shown += [event.path for event in engine.take_events() if isinstance(event, Entered)]
    assert shown == ["/a", "/b"]


def test_its_end_resyncs_a_mirror_with_the_next_state(bench):
    root = bench.machine()
    with root:
        bench.add("both", both(bench, ScriptedState(), ScriptedState()), {"finished": "next"}, {})
        bench.add("next", ScriptedState([None]), {"done": "finished"}, {"done": 0})
    engine = bench.engine(root, level=3, supervised=True)
    engine.run(0.0)
    engine.run(1.0)
    assert Synced("/next") in engine.take_events()


def test_a_first_state_that_ends_alone_is_followed_by_a_sync_with_the_next(bench):
    root = bench.machine()
    with root:
        container = both(bench, ScriptedState(), ScriptedState([None, "done"]))
        bench.add("both", container, {"finished": "next"}, {})
        bench.add("next", ScriptedState([None]), {"done": "finished"}, {"done": 0})
    engine = bench.engine(root, level=3, supervised=True)
    engine.run(0.0)
    events = [event for event in engine.take_events() if not isinstance(event, Entered)]
    assert events == [Left("/both/a", "done", 0), Shown("/both/b"), Synced("/both/b")]
    engine.run(1.0)
    assert engine.take_events() == [Shown("/next"), Synced("/next")], "b is not supervised"


# Priority


def with_priority(bench, priority_states, sibling):
    priority = bench.sequence(bench.priority(["done"]), *priority_states)
    return both(bench, priority, sibling)


def test_siblings_of_a_priority_container_are_paused_while_it_is_active(bench):
    sibling = ScriptedState([None, "done"])
    container = with_priority(bench, [ScriptedState([None, None, "done"])], sibling)
    assert bench.run(bench.engine(container)) == "finished"
    assert events(sibling.log, "b") == ["pause", "enter", "resume", "execute", "execute", "exit"]


def test_nested_priority_containers_give_priority_back_one_by_one(bench):
    inner = bench.sequence(bench.priority(["done"]), ScriptedState([None, "done"]))
    outer = bench.priority(["done"])
    with outer:
        bench.add("inner", inner, {"done": "rest"}, {})
        bench.add("rest", ScriptedState([None, "done"]), {"done": "done"}, {})
    sibling = ScriptedState()
    engine = bench.engine(both(bench, outer, sibling))
    engine.run(0.0)
    assert engine.priority == "/a/inner"
    engine.run(1.0)
    assert engine.priority == "/a"
    assert bench.run(engine) == "finished"
    assert engine.priority is None


def test_preempt_gives_priority_back(bench):
    container = with_priority(bench, [ScriptedState([None])], ScriptedState([None]))
    engine = bench.engine(container)
    engine.run(0.0)
    assert engine.priority == "/a"
    engine.handle(Preempt())
    engine.run(0.0)
    assert engine.priority is None


def test_a_pause_of_the_supervised_state_pauses_its_siblings(bench):
    sibling = ScriptedState([None])
    engine = bench.engine(both(bench, ScriptedState([None]), sibling), level=3, supervised=True)
    engine.run(0.0)
    engine.handle(Pause())
    engine.run(1.0)
    engine.run(2.0)
    assert events(sibling.log, "b") == ["enter", "execute", "pause"]
    engine.handle(Resume())
    engine.run(3.0)
    assert events(sibling.log, "b")[3:] == ["resume", "execute"]
