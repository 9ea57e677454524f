"""Where a behavior is, worked out from what its engine tells; no ROS."""
