"""Behaviors: parameters, contained behaviors, inputs."""

import pytest

from flexbe_core import Autonomy, Behavior, OperatableStateMachine
from flexbe_core.engine.engine import Engine
from flexbe_core.testing import ScriptedState


class Inner(Behavior):
    def __init__(self):
        super().__init__()
        self.name = "Inner"
        self.add_parameter("speed", 1.0)
        self.add_parameter("count", 3)

    def create(self):
        root = OperatableStateMachine(outcomes=["done"], input_keys=["b", "a", "c"])
        root.userdata.a, root.userdata.b, root.userdata.c = 1, 2, 3
        with root:
            OperatableStateMachine.add("x", ScriptedState(), {"done": "done"}, {"done": 0})
        return root


class Outer(Behavior):
    def __init__(self):
        super().__init__()
        self.name = "Outer"
        self.add_parameter("speed", 1.0)
        self.add_parameter("quick", False)
        self.add_parameter("limits", {})
        self.add_parameter("text", "a")
        self.add_behavior(Inner, "A")
        self.add_behavior(Inner, "A2")

    def create(self):
        root = OperatableStateMachine(outcomes=["done"])
        root.userdata.part = None
        inner = self.use_behavior(Inner, "A", default_keys=["a"], parameters={"count": 9})
        with root:
            OperatableStateMachine.add(
                "A",
                inner,
                {"done": "done"},
                {"done": Autonomy.Inherit},
                remapping={"b": "part", "c": "part"},
            )
        return root


@pytest.fixture
def outer():
    return Outer()


def test_a_plain_key_sets_the_parameter_everywhere(outer):
    assert outer.set_parameter("speed", "2.5")
    assert [outer.speed, outer.contains["A"].speed, outer.contains["A2"].speed] == [2.5] * 3
    assert outer.set_parameter("/speed", 3)
    assert outer.contains["A"].speed == 3.0


def test_a_path_sets_it_there_only(outer):
    assert outer.set_parameter("/A/speed", 2)
    assert [outer.speed, outer.contains["A"].speed, outer.contains["A2"].speed] == [1.0, 2.0, 1.0]


@pytest.mark.parametrize("name", ["unknown", "/B/speed", "A/speed", "name", "create", "_debug"])
def test_what_is_no_parameter_is_not_set(outer, name):
    assert not outer.set_parameter(name, "1")
    assert outer.name == "Outer"


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("quick", "True", True),
        ("quick", "0", False),
        ("quick", "false", False),
        ("limits", "{force: 3}", {"force": 3}),
        ("text", "5", "5"),
        ("/A/count", "7", 7),
    ],
)
def test_text_becomes_the_type_of_the_parameter(outer, name, text, value):
    assert outer.set_parameter(name, text)
    path, _, key = name.rpartition("/")
    assert getattr(outer.contains["A"] if path else outer, key) == value


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("speed", "soon"),
        ("/A/count", "1.5"),
        ("limits", "3"),
        ("limits", "{"),
        ("limits", "!!python/object:os.system {}"),
    ],
)
def test_text_that_does_not_fit_is_an_error_that_names_both(outer, name, text):
    with pytest.raises(ValueError, match="takes a value of type") as caught:
        outer.set_parameter(name, text)
    assert repr(text) in str(caught.value)


def test_a_contained_behavior_reads_its_inputs_from_outside_but_for_default_keys(outer):
    root = outer.create()
    inner = root["A"]
    assert inner.input_keys == ["b", "c"], "the order is kept"
    assert "b" not in inner.userdata
    assert inner.userdata.a == 1
    assert outer.contains["A"].count == 9


def test_a_behavior_that_was_not_declared_is_no_container(outer, capsys):
    assert outer.use_behavior(Inner, "B") is None


def test_inputs_replace_defaults(outer):
    outer.set_up(5, 255, False)
    outer.prepare_for_execution({"part": "A7", "unknown": 1})
    assert outer._state_machine.userdata.part == "A7"
    assert "unknown" not in outer._state_machine.userdata
    assert outer._state_machine.autonomy_level == 255
    assert OperatableStateMachine.autonomy_level == 3, "the level belongs to the behavior"


def test_a_behavior_without_create_says_so():
    with pytest.raises(NotImplementedError, match="'unnamed behavior' does not define create"):
        Behavior().prepare_for_execution()


def test_a_behavior_runs(outer):
    assert Engine(outer.create()).run(0.0) == "done"


def test_all_states_are_stopped_if_one_ends_the_program_at_its_start(monkeypatch):
    class Exiting(ScriptedState):
        def on_start(self):
            raise SystemExit(3)

    monkeypatch.setattr("flexbe_core.ros.session.connect", lambda: None)
    log, machine = [], OperatableStateMachine(outcomes=["finished"])
    with machine:
        OperatableStateMachine.add("A", ScriptedState(log=log), {"done": "B"})
        OperatableStateMachine.add("B", Exiting(log=log), {"done": "finished"})
    with pytest.raises(SystemExit):
        machine.confirm("Exiting", 1)
    assert log == [("A", "start"), ("A", "stop"), ("B", "stop")]
