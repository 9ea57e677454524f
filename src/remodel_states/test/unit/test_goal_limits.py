"""No goal exceeds the limits of the cell, and a malformed table of limits is refused."""

from types import SimpleNamespace

import pytest

from remodel_states.core.contract import beyond_limit, limits_of
from remodel_states.core.tables import TableError

TABLE = {"force_limit": 25, "speed_m_s": 0.25, "InsertCable": {"force_limit": 20.0}}


def test_the_lower_limit_holds():
    assert limits_of("InsertCable", TABLE) == {"force_limit": 20.0, "speed_m_s": 0.25}
    assert limits_of("PlaceConnector", TABLE) == {"force_limit": 25.0, "speed_m_s": 0.25}
    assert limits_of("InsertCable", {**TABLE, "InsertCable": {"force_limit": 90}}) == {
        "force_limit": 25.0,
        "speed_m_s": 0.25,
    }
    assert limits_of("InsertCable", {}) == {}


def test_a_goal_beyond_a_limit_is_named_with_both_values():
    limits = limits_of("InsertCable", TABLE)
    assert beyond_limit(SimpleNamespace(force_limit=20.0), limits) == ""
    assert beyond_limit(SimpleNamespace(id="x"), limits) == ""
    for force in (20.5, -20.5):
        said = beyond_limit(SimpleNamespace(force_limit=force), limits)
        assert said.startswith(f"force_limit is {force:g}, at most 20 is allowed in this cell")


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ([1], r"\[1\] found; needed: {NAME: NUMBER}"),
        ({"InsertCable": 3}, "InsertCable: 3 found; needed: {NAME: NUMBER}"),
        ({"force_limit": "25"}, "force_limit: '25' found; needed: a number above 0"),
        ({"InsertCable": {"force_limit": 0}}, "InsertCable.force_limit: 0 found"),
        ({"force_limit": True}, "force_limit: True found"),
    ],
)
def test_a_malformed_table_is_refused_with_the_place(document, said):
    with pytest.raises(TableError, match=said):
        limits_of("InsertCable", document)
