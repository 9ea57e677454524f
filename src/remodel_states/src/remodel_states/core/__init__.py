"""The tables of abilities, error codes and faults, and what is generated from them. No ROS."""
