"""Arms: kinematics, limits, volume."""
