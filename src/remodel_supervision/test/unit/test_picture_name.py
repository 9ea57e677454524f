"""Names of a run's pictures say what they show."""

import pytest

from remodel_supervision.core.runs.picture_name import picture_name, seen_by


@pytest.mark.parametrize("label", ["W1-1-whole", "=A1_K1-2-rest"])
def test_a_name_states_camera_and_time(label):
    assert seen_by(picture_name(label, 12.3456, "wrist")) == ("wrist", 12.346)


@pytest.mark.parametrize("name", ["", "W1.jpg", "W1_12.345_wrist.png", "W1_12_wrist.jpg"])
def test_what_is_no_such_name_is_refused(name):
    with pytest.raises(ValueError, match=r"is no name of a run's picture"):
        seen_by(name)
