import ast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexbe_synthesizer.core.chart.model import (
    DEEPEST,
    format_literal,
    freeze,
    parse_literal,
    python_literal,
    quote,
    type_of,
)

SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-(10**17), 10**17)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text()
)
KEYS = st.text() | st.integers(-(10**17), 10**17)
LITERALS = st.recursive(
    SCALARS, lambda inner: st.lists(inner) | st.dictionaries(KEYS, inner), max_leaves=12
)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        (" -5 ", -5),
        ("+0.5", 0.5),
        ("1e3", 1000.0),
        ("true", True),
        ("False", False),
        ("null", None),
        ("None", None),
        ("'5'", "5"),
        ('"a \\"b\\""', 'a "b"'),
        ("[1, 'a', [true]]", (1, "a", (True,))),
        ("{'on': true, 'to': null}", {"on": True, "to": None}),
        ('{"a": [1.5]}', {"a": (1.5,)}),
        ("", ""),
        ("W12", "W12"),
        ("007", "007"),
        ("1_000", "1_000"),
        ("nan", "nan"),
        ("1e999", "1e999"),
        ("[1, 2", "[1, 2"),
        ("(1, 2)", "(1, 2)"),
        ("{1, 2}", "{1, 2}"),
        ("[1+2j]", "[1+2j]"),
        ("[NaN]", "[NaN]"),
        ("[x]", "[x]"),
        ("['a'.upper()]", "['a'.upper()]"),
        ("__import__('os').getcwd()", "__import__('os').getcwd()"),
        ("9" * 5000, "9" * 5000),
        ("[" * 100_000, "[" * 100_000),
        ("[" * 51 + "]" * 51, "[" * 51 + "]" * 51),
        ("[0x" + "f" * 5000 + "]", "[0x" + "f" * 5000 + "]"),
        ("{0x" + "f" * 5000 + ": 1}", "{0x" + "f" * 5000 + ": 1}"),
        ('"\\ud800"', '"\\ud800"'),
    ],
)
def test_a_text_is_the_literal_it_spells_or_a_string(text, value):
    found = parse_literal(text)
    assert (type(found), found) == (type(value), value)


@given(LITERALS)
def test_what_is_written_is_read_as_the_same_literal(value):
    frozen = freeze(value)
    assert repr(parse_literal(format_literal(frozen))) == repr(frozen)


@given(LITERALS)
def test_the_python_expression_is_one_line_that_means_the_same(value):
    source = python_literal(freeze(value))
    assert "\n" not in source
    assert repr(freeze(ast.literal_eval(source))) == repr(freeze(value))


@given(st.text())
def test_a_quoted_text_has_nothing_that_misleads_the_app(text):
    source = quote(text)
    assert ast.literal_eval(source) == text
    assert not set(source[1:-1]) & set("'\"#()[]{}=\n\r")
    assert " def " not in source


def test_what_is_no_literal_is_refused():
    for value in (object(), {1, 2}, float("nan"), {None: 1}, [b"x"], 1 << 20_000, {"\ud800": 1}):
        with pytest.raises(TypeError, match="no literal of a chart"):
            freeze(value)


def test_a_list_nests_as_deeply_as_python_can_read_it():
    text = "[" * DEEPEST + "]" * DEEPEST
    value = parse_literal(text)
    assert isinstance(value, tuple)
    assert ast.literal_eval(python_literal(value)) == ast.literal_eval(text)


def test_types_have_the_names_of_the_language():
    values = (True, 1, 1.0, "a", (), {}, None)
    names = ["bool", "int", "float", "string", "list", "dict", None]
    assert [type_of(v) for v in values] == names
