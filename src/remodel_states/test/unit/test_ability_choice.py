"""Which abilities a node serves, from its parameters."""

import pytest

from remodel_states.core.tables import chosen_abilities

KNOWN = ["DetectCable", "InsertCable", "PickCable"]


@pytest.mark.parametrize(
    ("abilities", "others", "served"),
    [
        ("", "", KNOWN),
        ("", [], KNOWN),
        ([], "", []),
        ("PickCable, DetectCable", "", ["DetectCable", "PickCable"]),
        (["PickCable"], "", ["PickCable"]),
        ("", "InsertCable", ["DetectCable", "PickCable"]),
        ("InsertCable,PickCable", ["PickCable"], ["InsertCable"]),
        ("PickCable", "PickCable", []),
    ],
)
def test_abilities_are_chosen_by_name(abilities, others, served):
    assert chosen_abilities(KNOWN, abilities, others) == served


@pytest.mark.parametrize(
    ("abilities", "others", "problem"),
    [
        ("Pick", "", "'abilities' names no ability: Pick; there are DetectCable, InsertCable"),
        ("", "PickCabel", "'except' names no ability: PickCabel"),
        (3, "", "'abilities' is 3; allowed: names of abilities"),
    ],
)
def test_a_wrong_name_is_refused(abilities, others, problem):
    with pytest.raises(ValueError, match=problem):
        chosen_abilities(KNOWN, abilities, others)
