"""What a test case says; no ROS, no disk."""
