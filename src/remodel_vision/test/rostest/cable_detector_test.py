#!/usr/bin/env python3
"""The node cable_detector: its service, its topics, and what it refuses."""

import sys
import unittest

import cv2
import numpy as np
import rospy
import rostest
from remodel_msgs.msg import ImageCables
from remodel_msgs.srv import DetectCables, DetectCablesRequest
from sensor_msgs.msg import Image

WAIT_S = 60.0
RED, BLUE = (200, 40, 40), (40, 40, 200)


def message(pixels, encoding):
    height, width = pixels.shape[:2]
    step = pixels.nbytes // height
    image = Image(height=height, width=width, encoding=encoding, step=step, data=pixels.tobytes())
    image.header.frame_id = "camera"
    return image


def photograph():
    picture = np.full((240, 320, 3), 160, np.uint8)
    cv2.line(picture, (60, 80), (250, 100), RED, 7, cv2.LINE_AA)
    cv2.line(picture, (60, 160), (250, 200), BLUE, 7, cv2.LINE_AA)
    return picture


class CableDetectorTest(unittest.TestCase):
    def call(self, **request):
        name = "/cable_detector/detect_cables"
        rospy.wait_for_service(name, WAIT_S)
        return rospy.ServiceProxy(name, DetectCables)(DetectCablesRequest(**request))

    def test_the_service_finds_the_cables_of_an_image(self):
        answer = self.call(image=message(photograph(), "rgb8"))
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.found.header.frame_id, "camera")
        self.assertEqual(len(answer.found.cables), 2)
        for cable in answer.found.cables:
            self.assertEqual(cable.ends, ["tip", "tip"])
            self.assertGreater(len(cable.centreline), 50)

    def test_the_service_uses_what_is_known_beforehand(self):
        mirrored = message(np.ascontiguousarray(photograph()[..., ::-1]), "bgr8")
        (cable,) = self.call(image=mirrored, colours=bytes(BLUE), widths=[8.0]).found.cables
        self.assertGreater(cable.colour[2], cable.colour[0])
        upper = np.zeros((240, 320), np.uint8)
        upper[:120] = 255
        mask = message(upper, "mono8")
        (cable,) = self.call(image=mirrored, mask=mask).found.cables
        self.assertGreater(cable.colour[0], cable.colour[2])
        self.assertEqual(self.call(image=mirrored, background=mirrored).found.cables, [])

    def test_the_service_refuses_what_is_no_image(self):
        image = message(photograph(), "rgb8")
        image.encoding = "bayer_rggb8"
        self.assertIn("it must be one of rgb8, bgr8, mono8", self.call(image=image).message)
        image.encoding, image.data = "rgb8", image.data[:-1]
        self.assertIn("rows of 960 bytes or more", self.call(image=image).message)
        whole = message(photograph(), "rgb8")
        self.assertIn("red, green and blue", self.call(image=whole, colours=bytes(4)).message)

    def test_an_image_on_the_topic_is_answered(self):
        images = rospy.Publisher("/image", Image, queue_size=1, latch=True)
        images.publish(message(photograph(), "rgb8"))
        answers = []
        listener = rospy.Subscriber("/cable_detector/cables", ImageCables, answers.append)
        # The node answers only while a node listens; the image is repeated until then.
        limit = rospy.Time.now() + rospy.Duration(WAIT_S)
        while not answers and rospy.Time.now() < limit:
            images.publish(message(photograph(), "rgb8"))
            rospy.rostime.wallsleep(0.2)
        listener.unregister()
        self.assertEqual(len(answers[0].cables), 2)


if __name__ == "__main__":
    rospy.init_node("test_cable_detector")
    rostest.rosrun("remodel_vision", "test_cable_detector", CableDetectorTest, sys.argv)
