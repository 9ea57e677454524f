"""Which state follows."""

import pytest
from flexbe_msgs.msg import Container

from flexbe_core import OperatableStateMachine
from flexbe_core.engine.definitions import structure_of
from flexbe_core.engine.supervision import checksum
from flexbe_core.testing import ScriptedState
from flexbe_mirror.flexbe_mirror import StructureError, Tree


def tree():
    inner = OperatableStateMachine(outcomes=["ok", "bad"])
    with inner:
        OperatableStateMachine.add(
            "Try", ScriptedState(outcomes=("yes", "no")), {"yes": "ok", "no": "Again"}
        )
        OperatableStateMachine.add(
            "Again", ScriptedState(outcomes=("yes", "no")), {"yes": "ok", "no": "bad"}
        )
    root = OperatableStateMachine(outcomes=["finished", "failed"])
    with root:
        OperatableStateMachine.add("Box", inner, {"ok": "Say", "bad": "failed"})
        OperatableStateMachine.add("Say", ScriptedState(), {"done": "finished"})
    return Tree(reversed(structure_of(root)))


def test_the_first_state_is_the_innermost():
    assert tree().first_state() == "/Box/Try"
    assert tree().first_state("/Say") == "/Say"


def test_outcomes_lead_to_siblings_out_of_containers_and_to_the_end():
    assert tree().follow("/Box/Try", 1) == "/Box/Again"
    assert tree().follow("/Box/Try", 0) == "/Say"
    assert tree().follow("/Box/Again", 1) is None
    assert tree().follow("/Say", 0) is None
    with pytest.raises(IndexError):
        tree().follow("/Say", 1)


def test_states_are_found_by_the_checksum_of_their_path():
    assert tree().state_with(checksum("/Box/Again")) == "/Box/Again"
    assert tree().state_with(17) is None


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        ([], "no root"),
        ([Container(path="", children=["A", "B"]), Container(path="/A")], "lacks /B"),
    ],
)
def test_a_structure_that_is_not_whole_is_refused(parts, text):
    with pytest.raises(StructureError, match=text):
        Tree(parts)
