#!/usr/bin/env python3
"""All pages keep axe-core's rules; in a real browser."""

import sys
from pathlib import Path

import rospy
import rostest

sys.path.insert(0, str(Path(__file__).parent))
from accessibility_case import PAGES, AccessibilityCase


class AccessibilityTest(AccessibilityCase):
    def test_no_rule_is_broken(self):
        broken = []
        for address, shown in PAGES.items():
            page = self.open_full(address)
            broken += self.broken(page, address, shown, "light")
            page.close()
        self.assertEqual([], broken, "\n".join(broken))


if __name__ == "__main__":
    rospy.init_node("test_accessibility")
    rostest.rosrun("remodel_console", "test_accessibility", AccessibilityTest)
