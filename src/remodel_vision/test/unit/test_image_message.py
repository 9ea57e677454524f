"""Pictures survive their way through messages, whichever encoding a driver has."""

import numpy as np
import pytest
import rospy

from remodel_vision.ros.image_message import depth_image, depth_of, image, read_image

NOW = rospy.Time(1)
COLOURS = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
DEPTHS = np.linspace(0.25, 1.0, 8).reshape(2, 4)


def test_colours_are_read_as_they_were_written():
    assert (read_image(image(COLOURS, "wrist", NOW)) == COLOURS).all()


def test_depths_are_read_as_they_were_written():
    assert depth_of(depth_image(DEPTHS, "wrist", NOW)) == pytest.approx(DEPTHS, abs=1e-7)


@pytest.mark.parametrize("big_endian", [False, True])
def test_depths_in_millimetres_are_read_in_metres(big_endian):
    message = depth_image(DEPTHS, "wrist", NOW)
    message.encoding, message.step, message.is_bigendian = "16UC1", 8, big_endian
    order = ">" if big_endian else "<"
    message.data = np.rint(1e3 * DEPTHS).astype(f"{order}u2").tobytes()
    assert depth_of(message) == pytest.approx(DEPTHS, abs=5e-4)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"encoding": "8UC1"}, "encoding '8UC1'; it must be one of 32FC1, 16UC1"),
        ({"data": b"short"}, "5 bytes in rows of 16; 32FC1 of 4 x 2 px has rows of 16 bytes"),
    ],
)
def test_depths_that_cannot_be_read_are_refused_with_what_was_found(change, says):
    message = depth_image(DEPTHS, "wrist", NOW)
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(ValueError, match=says):
        depth_of(message)
