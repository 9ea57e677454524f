"""Commands to a running engine, and its answers."""

from dataclasses import replace

from flexbe_core.engine.supervision import (
    NO_OUTCOME,
    Answered,
    Attach,
    Entered,
    ForceOutcome,
    Left,
    Lock,
    Pause,
    Preempt,
    Repeat,
    Requested,
    Resume,
    SetAutonomy,
    Shown,
    Sync,
    Synced,
    Unlock,
)
from flexbe_core.testing import ScriptedState


def two_states(bench, script=("done",), required=0):
    """Return a machine a -> b -> finished; leaving `a` needs `required`."""
    root = bench.machine()
    with root:
        state = ScriptedState(script, ["done", "failed"])
        bench.add("a", state, {"done": "b", "failed": "finished"}, {"done": required, "failed": 0})
        bench.add("b", ScriptedState([None]), {"done": "finished"}, {"done": 0})
    return root


def started(bench, level=3, **kwargs):
    root = two_states(bench, **kwargs)
    root._name = "My Behavior"
    return root, bench.engine(root, level, supervised=True)


def step(bench, engine, *commands):
    """Give commands, execute once and return what happened, but for entries."""
    for command in commands:
        engine.handle(command)
    outcome = engine.run(bench.now)
    bench.now += 1.0
    events = [event for event in engine.take_events() if not isinstance(event, Entered | Shown)]
    return events if outcome is None else [*events, outcome]


def test_a_transition_is_published_to_mirrors(bench):
    _, engine = started(bench)
    assert step(bench, engine) == [Left("/a", "done", 0)]


def test_a_state_that_is_supervised_by_itself_reports_its_outcome(bench):
    root = two_states(bench)
    engine = bench.engine(root, level=3)
    root["a"]._is_controlled = True
    assert step(bench, engine) == [Left("/a", "done", 0)]


def test_a_transition_that_needs_more_asks_once_and_waits(bench):
    _, engine = started(bench, level=1, required=1)
    assert step(bench, engine) == [Requested("/a", 0)]
    assert step(bench, engine) == []
    assert step(bench, engine, SetAutonomy(2)) == [Answered("autonomy"), Left("/a", "done", 0)]


def test_the_path_that_the_operator_was_asked_with_names_the_state(bench):
    _, engine = started(bench, level=1, required=1)
    (asked,) = step(bench, engine)
    answered, *_, left = step(bench, engine, ForceOutcome(asked.path, asked.index))
    assert (answered.command, left) == ("transition", Left("/a", "done", 0))


def test_a_state_that_changes_its_mind_withdraws_its_request(bench):
    _, engine = started(bench, level=1, required=1, script=["done", None, "done"])
    assert step(bench, engine) == [Requested("/a", 0)]
    assert step(bench, engine) == [Requested("/a", NO_OUTCOME)]
    assert step(bench, engine) == [Requested("/a", 0)]


def test_the_operator_forces_an_outcome(bench):
    root, engine = started(bench, script=[None])
    step(bench, engine)
    answer = Answered("transition", ("a", "a"))
    assert step(bench, engine, ForceOutcome("a", 1)) == [
        answer,
        Left("/a", "failed", 1),
        "finished",
    ]
    assert root["a"].log.count(("a", "execute")) == 1


def test_what_follows_a_forced_outcome_is_for_the_next_state(bench):
    _, engine = started(bench, script=[None])
    events = step(bench, engine, ForceOutcome("a", 0), ForceOutcome("b", 0))
    assert events == [Answered("transition", ("a", "a")), Left("/a", "done", 0)]
    assert step(bench, engine)[-1] == "finished"


def test_a_locked_state_keeps_its_outcome_until_unlocked(bench):
    root, engine = started(bench)
    assert step(bench, engine, Lock("")) == [Answered("lock", ("/a", "/a"))]
    assert step(bench, engine) == []
    assert root["a"].log.count(("a", "execute")) == 1
    assert step(bench, engine, Unlock("")) == [
        Answered("unlock", ("/a", "/a")),
        Left("/a", "done", 0),
    ]


def test_a_locked_container_is_not_left_but_its_states_are(bench):
    engine = bench.engine(bench.around(two_states(bench), "box"), supervised=True)
    assert step(bench, engine, Lock("/box"))[-1] == Left("/box/a", "done", 0)
    assert step(bench, engine, ForceOutcome("b", 0)) == [Answered("transition", ("b", "b"))]
    assert step(bench, engine) == []
    events = step(bench, engine, Unlock("/box"))
    assert events == [Answered("unlock", ("/box", "/box")), Left("/box/b", "done", 0), "finished"]


def test_a_request_is_withdrawn_when_the_state_is_locked(bench):
    _, engine = started(bench, level=1, required=1)
    assert step(bench, engine) == [Requested("/a", 0)]
    step(bench, engine, Lock(""))
    assert step(bench, engine) == [Requested("/a", NO_OUTCOME)]


def test_a_paused_state_is_not_executed_and_notified_once(bench):
    root, engine = started(bench, script=[None])
    assert step(bench, engine, Pause()) == [Answered("pause")]
    step(bench, engine)
    assert root["a"].log == [("a", "pause")]
    assert step(bench, engine, Resume()) == [Answered("resume")]
    assert root["a"].log == [("a", "pause"), ("a", "enter"), ("a", "resume"), ("a", "execute")]


def test_a_repeat_leaves_and_enters_again(bench):
    root, engine = started(bench, script=[None])
    step(bench, engine)
    assert step(bench, engine, Repeat()) == [Answered("repeat")]
    step(bench, engine)
    events = [event for _, event in root["a"].log]
    assert events == ["enter", "execute", "execute", "exit", "enter", "execute"]


def test_a_mirror_that_asks_is_answered_also_where_nothing_has_changed(bench):
    _, engine = started(bench, script=[None])
    step(bench, engine)
    engine.handle(Sync())
    engine.run(bench.now)
    assert engine.take_events() == [Shown("/a"), Synced("/a"), Answered("sync")]


def test_attach_sets_the_level_and_names_the_behavior(bench):
    _, engine = started(bench, level=255, script=[None])
    assert step(bench, engine, Attach(1)) == [Answered("attach", ("My Behavior",)), Synced("/a")]
    assert engine.supervision.autonomy_level == 1


def test_who_attaches_is_asked_again_what_was_asked_before(bench):
    _, engine = started(bench, level=1, required=1)
    assert step(bench, engine) == [Requested("/a", 0)]
    assert Requested("/a", 0) in step(bench, engine, Attach(1))


def test_an_unsupervised_state_ignores_commands_but_preempt(bench):
    root = two_states(bench, script=[None])
    engine = bench.engine(root)
    commands = [ForceOutcome("a", 0), Lock(""), Pause(), Repeat()]
    warnings = [event.text.split(":")[0] for event in step(bench, engine, *commands)]
    assert warnings == ["lock has no effect", "pause has no effect"]
    root._is_controlled = root["a"]._is_controlled = True
    assert step(bench, engine) == [], "they are not applied later either"
    assert step(bench, engine, Preempt())[-1] == "preempted"


def two_children(bench, second, points=("/b",), first=None, required=0, last="b"):
    """Return the engine of a container that runs `a`, which is supervised, beside `b`."""
    container = bench.concurrency([("finished", [(last, "done")])])
    with container:
        bench.add("a", first or ScriptedState([None]), {"done": "finished"}, {"done": required})
        bench.add("b", second, dict.fromkeys(second.outcomes, "finished"), {})
    engine = bench.engine(container, 3, supervised=True)
    container["b"]._is_controlled = False  # as ConcurrencyContainer leaves all but the first
    engine.supervision = replace(engine.supervision, breakpoints=frozenset(points))
    return engine


def test_a_breakpoint_stops_any_child_of_a_concurrency_container(bench):
    second = ScriptedState(["done"], ["done", "failed"])
    engine = two_children(bench, second)
    assert step(bench, engine) == [Requested("/b", 0)]
    assert step(bench, engine) == []
    refused, reason = step(bench, engine, ForceOutcome("b", 7))
    assert refused == Answered("transition", ("b", "b"))
    assert reason.text == "asked for outcome 7 of 'b'; it has 0: done, 1: failed"
    answer = step(bench, engine, ForceOutcome("b", 0))
    assert answer[0] == Answered("transition", ("b", "b"))
    assert answer[-1] == "finished"
    assert not engine.stopped
    assert [event for _, event in second.log].count("exit") == 1


def test_a_state_at_a_breakpoint_is_answered_when_the_supervised_one_has_ended(bench):
    engine = two_children(bench, ScriptedState(["done"]), first=ScriptedState(["done"]))
    assert Requested("/b", 0) in step(bench, engine)
    assert step(bench, engine, ForceOutcome("b", 0))[-1] == "finished"


def test_the_answer_at_a_breakpoint_may_be_another_outcome(bench):
    second = ScriptedState(["done"], ["done", "failed"])
    engine = two_children(bench, second)
    step(bench, engine)
    step(bench, engine, ForceOutcome("/b", 1))
    assert engine.root.results == {"b": "failed"}


def test_a_breakpoint_that_is_removed_lets_the_state_go(bench):
    engine = two_children(bench, ScriptedState(["done"]))
    assert step(bench, engine) == [Requested("/b", 0)]
    engine.supervision = replace(engine.supervision, breakpoints=frozenset())
    assert step(bench, engine)[0] == Requested("/b", NO_OUTCOME)
    assert not engine.stopped


def test_who_attaches_is_asked_again_at_a_breakpoint(bench):
    engine = two_children(bench, ScriptedState(["done"]))
    assert step(bench, engine) == [Requested("/b", 0)]
    assert Requested("/b", 0) in step(bench, engine, Attach(3))


def test_a_name_of_two_states_at_breakpoints_is_refused_with_their_paths(bench):
    inner = {}
    for label in "bc":
        inner[label] = bench.around(ScriptedState(["done"]), "x", ["done"])
    container = bench.concurrency([("finished", [("b", "done"), ("c", "done")])])
    with container:
        bench.add("a", ScriptedState([None]), {"done": "finished"}, {"done": 0})
        for label, machine in inner.items():
            bench.add(label, machine, {"done": "finished"}, {})
    engine = bench.engine(container, 3, supervised=True)
    for machine in inner.values():
        machine["x"]._is_controlled = False
    points = frozenset({"/b/x", "/c/x"})
    engine.supervision = replace(engine.supervision, breakpoints=points)
    assert step(bench, engine) == [Requested("/b/x", 0), Requested("/c/x", 0)]
    _, reason = step(bench, engine, ForceOutcome("x", 0))
    assert "name one of '/b/x', '/c/x'" in reason.text
    assert set(engine.stopped) == points, "nothing has moved"
    step(bench, engine, ForceOutcome("/c/x", 0))
    assert set(engine.stopped) == {"/b/x"}


def test_a_supervised_state_that_is_exited_withdraws_what_it_asks(bench):
    first, second = ScriptedState(["done"]), ScriptedState([None, "done"])
    engine = two_children(bench, second, (), first, required=3)
    assert step(bench, engine) == [Requested("/a", 0)]
    assert Requested("/a", NO_OUTCOME) in step(bench, engine)


def test_a_container_that_ends_withdraws_what_its_states_ask(bench):
    first, second = ScriptedState([None, "done"]), ScriptedState(["done"])
    engine = two_children(bench, second, first=first, last="a")
    assert step(bench, engine) == [Requested("/b", 0)]
    assert Requested("/b", NO_OUTCOME) in step(bench, engine)
    assert not engine.stopped


def test_who_preempts_is_not_told_that_nothing_is_asked(bench):
    engine = two_children(bench, ScriptedState(["done"]))
    assert step(bench, engine) == [Requested("/b", 0)]
    events = step(bench, engine, Preempt())
    assert not any(isinstance(event, Requested) for event in events)
    assert events[-1] == "preempted"
    assert not engine.stopped


def test_the_path_of_the_active_state_names_it_also_while_others_wait(bench):
    engine = two_children(bench, ScriptedState(["done"]))
    events = step(bench, engine, ForceOutcome("/a", 0))
    assert Answered("transition", ("/a", "/a")) in events
    assert Left("/a", "done", 0) in events
    assert "/b" in engine.stopped
