"""The mirror as a ROS node."""
