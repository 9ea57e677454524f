"""Names of error codes: what a table says of them, and what routes make of them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexbe_synthesizer.core.chart.error_routes import (
    ListedCode,
    codes_of_event,
    codes_of_routes,
    error_names,
    format_codes,
    format_routes,
    parse_routes,
    read_error_table,
    route_event,
)
from flexbe_synthesizer.core.chart.model import ErrorRoute
from flexbe_synthesizer.core.chart.names import is_readable_outcome
from flexbe_synthesizer.core.chart.problem import ProblemKind

LOST = {"code": 4, "name": "LOST"}
TABLE = {
    "no_fault": [{"code": 0, "name": "NONE"}, {"code": 2, "name": "CANCELLED"}],
    "faults": [
        {
            "codes": [LOST, {"code": 3, "name": "HUNG"}],
            "severity": "serious",
            "first_level": "task",
        },
        {"codes": [{"code": 9, "name": "STALE"}], "severity": "serious", "first_level": "use_case"},
        {
            "codes": [{"code": 301, "name": "JAMMED"}],
            "severity": "recoverable",
            "first_level": "task",
        },
        {
            "codes": [{"code": 302, "name": "MISSED"}],
            "severity": "recoverable",
            "first_level": "behavior",
        },
        {"after": {"fault": "missed", "times": 3}, "severity": "serious", "first_level": "task"},
    ],
}
NAMES = error_names(read_error_table(TABLE))

CHART = """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Push" initial="Insert">
  <datamodel><outcome name="finished"/><outcome name="failed"/><input name="cable_id"/>
    <input name="pose"/></datamodel>
  <state id="Insert" type="InsertCableState" ext:on_error="{routes}">
    <param name="force_limit_n" value="20"/>
    <transition event="inserted" target="finished"/>
    <transition event="failed" target="failed"/></state></statemachine>"""


def test_a_table_gives_the_names_of_its_codes_and_classes():
    assert NAMES == {
        "above_behavior": (3, 4, 9, 301),
        "recoverable": (301, 302),
        "serious": (3, 4, 9),
        "CANCELLED": (2,),
        "LOST": (4,),
        "HUNG": (3,),
        "STALE": (9,),
        "JAMMED": (301,),
        "MISSED": (302,),
    }


@pytest.mark.parametrize(
    ("table", "reason"),
    [
        ([], "a list of 'faults'"),
        ({"faults": {}}, "'faults' is {}; allowed: a list"),
        ({"no_fault": "NONE"}, "'no_fault' is 'NONE'; allowed: a list"),
        ({"faults": ["JAMMED"]}, "'JAMMED' is no fault"),
        ({"faults": [{"codes": 301}]}, "'codes' is 301; allowed: a list"),
        ({"faults": [{"codes": ["JAMMED"]}]}, "no 'name'"),
        ({"faults": [{"codes": [{"name": "two words", "code": 1}]}]}, "no 'name'"),
        ({"faults": [{"codes": [{"name": "JAMMED", "code": "301"}]}]}, "allowed: 0 to 32767"),
        ({"faults": [{"codes": [{"name": "JAMMED", "code": 40000}]}]}, "allowed: 0 to 32767"),
    ],
)
def test_what_is_no_table_is_refused_with_the_reason(table, reason):
    with pytest.raises(ValueError, match=reason):
        read_error_table(table)


def test_a_table_of_abilities_without_codes_of_its_own_gives_none():
    assert read_error_table({"abilities": {"CrimpFerrule": {"errors": ["JAMMED"]}}}) == ()


def test_the_classes_of_several_tables_are_joined_and_the_first_code_of_a_name_counts():
    other = {"faults": [{"codes": [{"code": 900, "name": "LOST"}], "severity": "serious"}]}
    both = error_names((*read_error_table(TABLE), *read_error_table(other)))
    assert (both["serious"], both["LOST"]) == ((3, 4, 9, 900), (4,))


def test_no_code_takes_the_name_of_a_class():
    assert error_names([ListedCode("serious", 8, "serious", "task")])["serious"] == (8,)
    assert "serious" not in error_names([ListedCode("serious", 8)])


def test_a_failure_takes_the_first_route_that_has_its_code():
    routes = parse_routes("JAMMED: a; serious: b; above_behavior: c; 1-8: d")
    assert codes_of_routes(routes, NAMES) == ((301,), (3, 4, 9), (), (1, 2, 5, 6, 7, 8))


@pytest.mark.parametrize("text", ["JAMMED: a; JAMMED: b", "two words: a", "1.5: a", "_x: a", ": a"])
def test_what_names_no_code_is_no_route(text):
    with pytest.raises(ValueError, match=text):
        parse_routes(text)


@given(st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,9}|[1-9][0-9]{0,3}", fullmatch=True))
def test_the_event_of_a_route_names_its_codes_and_the_app_can_read_it(codes):
    (route,) = parse_routes(f"{codes}: there")
    event = route_event(route)
    assert codes_of_event(event) == codes
    assert is_readable_outcome(event)
    assert " " not in event
    assert parse_routes(format_routes((route,))) == (route,)


@given(st.sets(st.integers(1, 60)))
def test_codes_in_numbers_are_all_of_them(codes):
    text = format_codes(sorted(codes))
    routes = tuple(ErrorRoute(each, "x") for each in text.split(", ") if each)
    assert {code for found in codes_of_routes(routes, {}) for code in found} == codes


def test_a_route_without_a_code_left_is_reported(check):
    (problem,) = check(CHART.format(routes="above_behavior: failed; JAMMED: finished"))[1]
    assert problem.code is ProblemKind.INVALID_VALUE
    assert problem.message == (
        "the route of 'JAMMED' is never taken: the routes before it take all its error codes; "
        "put it before them."
    )


def test_names_of_codes_are_right_where_they_are_known(check):
    assert check(CHART.format(routes="JAMMED: finished; above_behavior: failed"))[1] == ()
