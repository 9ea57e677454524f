"""Determines the active state of a behavior from the messages of its engine; no ROS."""
