"""The compiler itself: values in, values out; no ROS, clock, thread or disk."""
