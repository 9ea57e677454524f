"""State classes as the FlexBE App reads them."""

from pathlib import Path

import pytest

from flexbe_testing.core.app_behavior import FromParameter, judge_state, read_state

STATES = Path(__file__).parents[3] / "flexbe_states" / "src" / "flexbe_states"
FILES = sorted(STATES.glob("*_state.py"))
STATE = '''\
from flexbe_core import EventState


class MoveState(EventState):
    """Moves.

    <= done
    """

    def __init__(self, target, speed=[0.1, 0.2], topic="a b"):
        super(MoveState, self).__init__(
            outcomes=['done', "gave up"],
            input_keys=['pose'],
            output_keys=["error, code"],
            io_keys=['both'],
        )
'''


def test_a_state_is_read_by_its_text():
    state = read_state(STATE, "my_states.deeper.move_state")
    assert (state.class_name, state.package) == ("MoveState", "my_states")
    assert state.module == "my_states.deeper.move_state"
    assert state.parameters == {"target": None, "speed": "[0.1,0.2]", "topic": '"ab"'}
    assert state.outcomes == ("done", "gaveup")  # the App drops blanks
    assert (state.input_keys, state.output_keys) == (("pose",), ("error, code",))


@pytest.mark.parametrize(
    ("old", "new", "parameters"),
    [
        ("(self, target, speed=[0.1, 0.2], topic", "(\n        self, target, topic", []),
        ("(self, target, speed", "(self, target,\n                 speed", []),
        ("target, speed=[0.1, 0.2]", "target=(1, 2)", []),
        ("target, speed", "target: str, speed", ["target: str", "speed", "topic"]),
        ('(self, target, speed=[0.1, 0.2], topic="a b")', "(self)", []),
    ],
)
def test_parameters_that_do_not_stand_on_the_line_of_the_def_are_not_seen(old, new, parameters):
    assert old in STATE
    assert list(read_state(STATE.replace(old, new), "p.m").parameters) == parameters


def test_only_a_class_whose_base_is_event_state_itself_is_seen():
    assert read_state(STATE.replace("(EventState)", "(Base, EventState)"), "p.m") is None
    assert read_state("class A: pass", "p.m") is None


def test_lists_can_come_from_parameters_and_from_what_the_user_fills_in():
    text = STATE.replace("['done', \"gave up\"]", "target").replace("['pose']", "list(range(3))")
    state = read_state(text, "p.m")
    assert state.outcomes == FromParameter("target")
    assert state.input_keys == FromParameter("?input_keys")
    assert list(state.parameters) == ["target", "speed", "topic", "?input_keys"]


def test_the_app_sees_all_of_each_state_of_flexbe_states():
    assert len(FILES) > 10
    found = {
        file.stem: judge_state(file.read_text(), f"flexbe_states.{file.stem}") for file in FILES
    }
    assert {name: complaints for name, complaints in found.items() if complaints} == {}


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            "(self, target,",
            "(\n        self, target,",
            "line 10: the App does not see the arguments",
        ),
        ("target, speed", "target: str, speed", "does not see the arguments target of MoveState"),
        ("(EventState)", "(EventState, Base)", "line 4: the App does not see MoveState"),
        ("['pose']", "sorted(x)", "cannot read the input_keys of MoveState"),
        ("            outcomes=['done', \"gave up\"],\n", "", "sees no outcome of MoveState"),
        ("__init__(self, target", "start(self, target", "which has no __init__"),
    ],
)
def test_what_the_app_does_not_see_of_a_state_is_reported_with_its_line(old, new, complaint):
    assert old in STATE
    found = "\n".join(judge_state(STATE.replace(old, new), "p.m"))
    assert complaint in found, found


def test_keys_of_both_directions_and_outcomes_with_blanks_are_reported():
    assert judge_state(STATE, "p.m") == [
        "line 10: the App does not see io_keys of MoveState: list them as input and output",
        "line 10: the App reads outcome 'gave up' of MoveState as 'gaveup'",
    ]
