"""What a start request brings: inputs and modifications."""

import pytest

from flexbe_onboard.behavior_source import (
    Modification,
    StartError,
    modified,
    read_inputs,
    read_value,
)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("-1.5", -1.5),
        ("True", True),
        ("None", None),
        ("'text'", "text"),
        ("text", "text"),
        ("two words", "two words"),
        ("[1, {'a': 2}]", [1, {"a": 2}]),
        ("(1, 2)", (1, 2)),
        ("", ""),
        ("__import__('os').getcwd()", "__import__('os').getcwd()"),
        ("[" * 10_000, "[" * 10_000),
        ("{[]: 1}", "{[]: 1}"),
    ],
)
def test_a_literal_is_read_and_other_text_stays_text(text, value):
    assert read_value(text) == value


def test_dicts_can_be_read_as_attributes_at_any_depth():
    value = read_value("{'a': {'b': [{'c': 1}]}}")
    assert value.a.b[0].c == 1
    with pytest.raises(AttributeError, match="no value named 'd'"):
        value.a.d  # noqa: B018


def test_inputs_pair_keys_and_values_and_skip_empty_keys():
    assert read_inputs(["a", "", "b"], ["1", "2", "x"]) == {"a": 1, "b": "x"}


def test_a_key_without_a_value_is_refused():
    with pytest.raises(ValueError, match=r"1 values for 2 keys \(a, b\)"):
        read_inputs(["a", "b"], ["1"])


def test_modifications_count_characters_of_the_unmodified_text():
    changes = [Modification(0, 1, "AB"), Modification(2, 2, "+"), Modification(4, 5, "")]
    assert modified("\u00e4bcde", changes) == "ABb+cd"
    assert modified("abc", []) == "abc"


@pytest.mark.parametrize(
    "changes",
    [
        [Modification(2, 1, "")],
        [Modification(-1, 1, "")],
        [Modification(0, 9, "")],
        [Modification(2, 3, ""), Modification(1, 2, "")],
        [Modification(0, 2, ""), Modification(1, 3, "")],
    ],
    ids=["backwards", "before the text", "behind the text", "descending", "overlapping"],
)
def test_modifications_that_make_no_sense_are_refused(changes):
    with pytest.raises(StartError, match=r"modification \d replaces characters"):
        modified("abcde", changes)
