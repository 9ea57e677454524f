"""Servers, services and publishers: the only folder that imports ROS."""
