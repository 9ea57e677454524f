import pytest

from remodel_skills.cell import check_owner
from remodel_states.core.codes import Code
from remodel_states.core.contract import NO_OWNER, owner_of
from remodel_work.errors import AbilityError


@pytest.mark.parametrize(
    ("goal_id", "owner"),
    [
        ("17:insert a", 17),
        ("17:", 17),
        ("insert a", NO_OWNER),
        ("W17:insert", NO_OWNER),
        ("17 insert", NO_OWNER),
        ("-3:insert", NO_OWNER),
        ("", NO_OWNER),
    ],
)
def test_the_token_stands_in_front_of_the_id(goal_id, owner):
    assert owner_of(goal_id) == owner


def test_only_an_older_token_is_refused():
    for owner in (NO_OWNER, 17, 18):
        check_owner(owner, 17)
    with pytest.raises(AbilityError, match="owner 16 no longer owns this cell, owner 17") as caught:
        check_owner(16, 17)
    assert caught.value.code is Code.STALE_OWNER
