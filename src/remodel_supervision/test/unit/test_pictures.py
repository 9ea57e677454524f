"""Names of a run's pictures say what they show, and no behavior fails for want of one."""

from types import SimpleNamespace

import pytest
import rospy
from sensor_msgs.msg import Image

from remodel_supervision.core.runs.entries import picture_name, seen_by
from remodel_supervision.ros.peers.pictures import CellPictures


@pytest.mark.parametrize("label", ["W1-1-whole", "=A1_K1-2-rest"])
def test_a_name_states_camera_and_time(label):
    assert seen_by(picture_name(label, 12.3456, "wrist")) == ("wrist", 12.346)


@pytest.mark.parametrize("name", ["", "W1.jpg", "W1_12.345_wrist.png", "W1_12_wrist.jpg"])
def test_what_is_no_such_name_is_refused(name):
    with pytest.raises(ValueError, match=r"is no name of a run's picture"):
        seen_by(name)


def test_a_behavior_ends_though_its_pictures_cannot_be_kept(tmp_path, monkeypatch, full_disk):
    warnings = []
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_time", lambda: 12.0)
    monkeypatch.setattr(rospy, "logwarn", lambda text, *words: warnings.append(text % words))
    seen = Image(height=2, width=2, encoding="rgb8", step=6, data=bytes(12))
    pictures = CellPictures(SimpleNamespace(picture=lambda camera: seen), tmp_path)
    with full_disk():
        assert pictures.keep(1, "W1-1-whole") == ()
    assert len(warnings) == 1
    assert warnings[0].startswith("the pictures of W1-1-whole are not kept: [Errno")
    assert pictures.keep(1, "W1-2-whole") == ("W1-2-whole_12.000_scene.jpg",)
