"""The rooms that know ROS."""
