"""The userdata that a state found, as a start at that state gets it back."""

from io import BytesIO

import pytest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from remodel_msgs.msg import InsertCableGoal
from std_msgs.msg import Header

from flexbe_onboard.core.input_values import read_value
from remodel_console.core.run.state_values import StateValues, literal_of, values_around

ASKED = (
    ("Place Connector", "cable_id", "str", "W1"),
    ("Place Connector/Connect a/", "depth", "float", "0.5"),
    ("Place Connector/Connect b/", "depth", "float", "0.7"),
    ("Place Connector", "image", "Image", "x" * 30_000),
    ("Place Connector", "client", "object", "<object at 0x7f>"),
)


def test_values_of_the_containers_around_a_state_are_kept_by_their_names():
    found = values_around("/Connect a/Insert", ASKED)
    names = {value.name: value.literal for value in found}
    assert names == {
        "cable_id": "'W1'",
        "/Connect a/depth": "0.5",
        "image": "",
        "client": "",
    }
    kept = StateValues(2.0, "/Connect a/Insert", found)
    assert StateValues.from_json(kept.as_json()) == kept


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
