"""Tables of abilities, error codes and faults, what is generated from them; wires. No ROS."""
