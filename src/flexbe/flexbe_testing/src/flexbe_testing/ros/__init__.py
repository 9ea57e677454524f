"""Run test cases in a ROS node."""
