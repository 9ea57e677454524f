"""Userdata, rule by rule of FlexBE's contract."""

import pytest
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from flexbe_core.core.exceptions import UserDataError
from flexbe_core.core.user_data import UserData


def root(**values):
    data = UserData()
    for key, value in values.items():
        data[key] = value
    return data


def test_hand_made_data_has_no_restrictions():
    data = UserData()
    data.x = 1
    assert data.x == data["x"] == 1
    assert "x" in data
    assert len(data) == 1


def test_empty_data_is_false():
    assert not UserData()


def test_an_input_is_read_through_the_remapping():
    view = UserData(root(far=5), ["near"], [], {"near": "far"})
    assert "near" in view
    assert view.near == 5


def test_a_key_without_remapping_maps_to_itself():
    assert UserData(root(x=5), ["x"], []).x == 5


def test_an_output_is_written_through_the_remapping_at_once():
    data = root()
    UserData(data, [], ["near"], {"near": "far"}).near = 5
    assert data.far == 5
    assert "near" not in data


def test_reading_an_undeclared_key_names_what_is_declared():
    with pytest.raises(UserDataError, match=r"'y' is not declared as input; declared: x"):
        UserData(root(y=1), ["x"], []).y  # noqa: B018


def test_reading_a_key_that_was_never_written_names_its_source():
    with pytest.raises(UserDataError, match=r"no data for key 'x' \(it is remapped to 'z'\)"):
        UserData(root(), ["x"], [], {"x": "z"}).x  # noqa: B018


def test_an_output_can_be_read_back_once_it_is_written():
    view = UserData(root(x=1), [], ["x"])
    with pytest.raises(UserDataError):
        view.x  # noqa: B018
    view.x = 2
    assert view.x == 2


def test_writing_an_undeclared_attribute_is_an_error():
    view = UserData(root(), ["x"], ["y"])
    with pytest.raises(UserDataError, match=r"'x' is not declared as output; declared: y"):
        view.x = 1


def test_writing_an_undeclared_item_stays_local():
    data = root()
    view = UserData(data, [], [])
    view["x"] = 1
    assert view["x"] == 1
    assert "x" not in data


def test_underscore_names_are_attributes_of_the_object():
    data = UserData()
    data._x = 1
    assert data._x == 1
    assert "_x" not in data
    with pytest.raises(AttributeError):
        data._y  # noqa: B018


def test_data_written_inside_reaches_the_outside_only_as_declared_output():
    outside = root()
    container = UserData(outside, [], ["out"])
    leaf = UserData(container, [], ["out", "inner"])
    leaf.out, leaf.inner = 1, 2
    assert outside.out == 1
    assert container["inner"] == 2
    assert "inner" not in outside


@pytest.mark.parametrize(
    ("value", "change"),
    [
        ([1, 2], lambda value: value.append(3)),
        (list(range(100)), lambda value: value.__setitem__(50, -1)),
        ({"a": [1]}, lambda value: value["a"].append(2)),
        ({1, 2}, lambda value: value.add(3)),
        (bytearray(b"abc"), lambda value: value.__setitem__(0, 0)),
        (Image(), lambda value: setattr(value, "width", 1)),
        ((1, [2]), lambda value: value[1].append(3)),
    ],
    ids=["list", "long list", "dict", "set", "buffer", "message", "tuple"],
)
def test_changing_an_input_in_place_is_an_error(value, change):
    with (
        pytest.raises(UserDataError, match="'x' was changed"),
        UserData(root(x=value), ["x"], []) as view,
    ):
        change(view.x)


def test_a_key_that_is_input_and_output_may_be_changed_in_place():
    value = [1]
    with UserData(root(x=value), ["x"], ["x"]) as view:
        view.x.append(2)
    assert value == [1, 2]


def test_reading_inputs_is_no_change():
    with UserData(root(x=[1], y=Image()), ["x", "y"], []) as view:
        assert view.x == [1]
        assert view.x is view.x
        assert view.y is view.y


def test_a_message_is_lent_not_copied_and_may_be_published():
    image = Image(data=b"\0" * 900_000)
    with UserData(root(image=image), ["image"], []) as view:
        assert view.image is image
        view.image.header.seq = 7  # what publishing does


def test_a_changed_header_beyond_what_publishing_sets_is_an_error():
    message = Header(seq=1)
    with pytest.raises(UserDataError), UserData(root(x=message), ["x"], []) as view:
        view.x.stamp.secs = 5


def test_an_error_on_its_way_is_not_hidden():
    with pytest.raises(KeyError), UserData(root(x=[1]), ["x"], []) as view:
        view.x.append(2)
        raise KeyError("first")


def test_a_view_that_contains_itself_can_be_checked():
    loop = [1]
    loop.append(loop)
    with UserData(root(x=loop), ["x"], []) as view:
        assert view.x[0] == 1


def test_calling_a_view_retargets_and_merges_it():
    view = root(x=1)
    view(add_from=root(x=2, y=3))
    assert (view.x, view.y) == (1, 3)
    view(update_from=root(x=2))
    assert view.x == 2
    view(remove_key="x")
    assert "x" not in view
    view(reference=root(z=4))
    assert view.z == 4


def test_text_shows_own_and_referred_values():
    assert str(UserData(root(x=1), ["x"], [])) == "UserData() on UserData(x=1)"
