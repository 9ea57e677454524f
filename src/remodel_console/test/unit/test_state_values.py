"""The userdata that a state found, as a start at that state gets it back."""

from io import BytesIO

import pytest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from remodel_msgs.msg import InsertCableGoal
from std_msgs.msg import Header

from flexbe_core.engine.visit import VisitText
from flexbe_onboard.behavior_source import read_value
from remodel_console.core.cell import Row, StateValues, literal_of, values_around
from remodel_console.watched import RunValues

KNOWN = {
    ("", "cable_id"): ("str", "W1"),
    ("/Connect a", "depth"): ("float", "0.5"),
    ("/Connect b", "depth"): ("float", "0.7"),
    ("", "image"): ("Image", "<921600 bytes>"),
    ("", "text"): ("str", "x" * 30_000),
    ("", "client"): ("object", "<object at 0x7f>"),
}


def test_values_of_the_containers_around_a_state_are_kept_by_their_names():
    found = values_around("/Connect a/Insert", KNOWN)
    names = {value.name: value.literal for value in found}
    assert names == {
        "cable_id": "'W1'",
        "/Connect a/depth": "0.5",
        "image": "",
        "text": "",
        "client": "",
    }
    kept = StateValues(2.0, "/Connect a/Insert", found)
    assert StateValues.from_json(kept.as_json()) == kept


def visit(number, path, *, left=False, changed=(), complete=(), run=1):
    """Return a visit; what the state reads or writes are the values with a name of its own."""
    values = {place: (kind, text) for place, kind, text in changed}
    keys = {"depth": ("/Connect a", "depth"), "cable": ("", "cable_id")}
    return VisitText(number, run, 2.0, path, left, complete, values, keys)


INSERT = "/Connect a/Insert"
FIRST = ((("", "cable_id"), "str", "W1"), (("/Connect a", "depth"), "float", "0.5"))


def test_a_state_shows_what_it_found_and_what_it_left_behind():
    values = RunValues()
    assert values.take(visit(1, INSERT, changed=FIRST, complete=("", "/Connect a")))
    assert values.rows("/Nowhere", INSERT) == (Row("depth", "0.5"), Row("cable", "W1"))
    deeper = ((("/Connect a", "depth"), "float", "0.8"),)
    assert values.take(visit(2, INSERT, left=True, changed=deeper))
    assert values.rows(INSERT) == (Row("depth", "0.5", "0.8"), Row("cable", "W1", "W1"))
    assert values.rows("/Connect a") == (Row("depth", "0.8"),), "what the container has"
    (found,) = values.found
    assert {one.name: one.literal for one in found.values}["/Connect a/depth"] == "0.5"
    assert values.take(visit(3, "/Other", complete=("",), run=2))
    assert values.rows(INSERT) == (), "that was another run"


def test_values_are_unknown_after_a_lost_message():
    values = RunValues()
    assert values.take(visit(1, INSERT, changed=FIRST, complete=("", "/Connect a")))
    assert not values.take(visit(3, INSERT))
    assert len(values.found) == 1, "nothing is recorded that may be wrong"
    assert values.take(visit(4, INSERT, changed=FIRST, complete=("", "/Connect a")))
    assert len(values.found) == 2


@pytest.mark.parametrize(
    "value", ["W1", "5", "it's", 5, 0.25, True, None, [1, "a"], (1.0, 2.0), {"a": {"b": [1]}}]
)
def test_what_a_state_found_is_what_the_engine_gives_it_again(value):
    literal = literal_of(type(value).__name__, str(value))
    assert read_value(literal) == value


def test_a_message_is_given_back_by_its_fields():
    pose = Pose(Point(0.1, -0.2, 3e-7), Quaternion(0.0, 0.0, 0.0, 1.0))
    message = PoseStamped(Header(frame_id="panel"), pose)
    given = read_value(literal_of("PoseStamped", str(message)))
    assert serialized(socket_goal(given)) == serialized(socket_goal(message))


def socket_goal(pose):
    return InsertCableGoal(cable_id="W1", socket_pose=pose)


def serialized(goal):
    buffer = BytesIO()
    goal.serialize(buffer)
    return buffer.getvalue()
