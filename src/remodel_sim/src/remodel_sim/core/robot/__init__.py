"""The robot: kinematics, the volume it occupies, its motions and what it feels."""
