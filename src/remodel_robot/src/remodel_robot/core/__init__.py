"""Computations without disk or ROS."""
