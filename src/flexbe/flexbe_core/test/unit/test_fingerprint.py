"""Which changes a fingerprint finds, in random messages at random places."""

import copy
import random

import pytest
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import PointField
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from flexbe_core.engine.user_data import fingerprint, is_unchanged

SIZES = (1, 3, 64, 65, 200)


def path(rng):
    return Path(poses=[PoseStamped() for _ in range(rng.choice(SIZES))])


def markers(rng):
    points = [[Point(x=rng.random()) for _ in range(rng.choice(SIZES))] for _ in range(4)]
    return MarkerArray(markers=[Marker(points=points[n % 4]) for n in range(rng.choice(SIZES))])


def trajectory(rng):
    points = [JointTrajectoryPoint(positions=[0.0] * 6) for _ in range(rng.choice(SIZES))]
    return JointTrajectory(joint_names=["a", "b"], points=points)


def mixed(rng):
    return [rng.choice([1, 2.0, "x", [3], Point(), PointField()]) for _ in range(200)]


def places(value, found, path=()):
    """Collect (holder, key or attribute) of every plain value below `value`."""
    if isinstance(value, list):
        held = [(value, index, item) for index, item in enumerate(value)]
    else:
        names = [
            name for name in getattr(value, "__slots__", ()) if name not in ("seq", "frame_id")
        ]
        held = [(value, name, getattr(value, name)) for name in names]
    for holder, key, item in held:
        if isinstance(item, int | float | str):
            found.append((holder, key))
        places(item, found)
    return found


def change(rng, value):
    """Change one plain value in place: to another one, or to an equal one of another type."""
    holder, key = rng.choice(places(value, []))
    old = holder[key] if isinstance(holder, list) else getattr(holder, key)
    new = float(old) if type(old) is int and rng.random() < 0.5 else f"not {old}"
    if isinstance(holder, list):
        holder[key] = new
    else:
        setattr(holder, key, new)
    return old, new


@pytest.mark.parametrize("make", [path, markers, trajectory, mixed])
def test_every_change_of_a_plain_value_is_found_and_nothing_else(make):
    rng = random.Random(make.__name__)
    for _ in range(25):
        value = make(rng)
        before = fingerprint(value)
        assert is_unchanged(before, fingerprint(value))
        assert is_unchanged(before, fingerprint(copy.deepcopy(value)))
        changed = change(rng, value)
        assert not is_unchanged(before, fingerprint(value)), changed


def test_what_is_added_removed_or_replaced_in_a_long_list_is_found():
    value = path(random.Random(0))
    value.poses = [PoseStamped() for _ in range(100)]
    before = fingerprint(value)
    value.poses[70].pose = None
    assert not is_unchanged(before, fingerprint(value))
    value.poses[70] = PoseStamped()
    assert is_unchanged(before, fingerprint(value))
    last = value.poses.pop()
    assert not is_unchanged(before, fingerprint(value))
    value.poses.append(last)
    del value.poses[3].pose
    assert not is_unchanged(before, fingerprint(value))


class Link:
    __slots__ = ("following",)

    def __init__(self, following):
        self.following = following


def test_objects_that_hold_themselves_have_a_fingerprint():
    links = [Link(None) for _ in range(100)]
    for link, following in zip(links, [*links[1:], links[0]], strict=True):
        link.following = following
    before = fingerprint(links)
    assert is_unchanged(before, fingerprint(links))
    links[50].following = None
    assert not is_unchanged(before, fingerprint(links))
