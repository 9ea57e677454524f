"""The engine as a ROS node."""
