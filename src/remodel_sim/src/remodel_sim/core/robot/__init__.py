"""The robot: kinematics, the volume it occupies, its motions and the forces of a push."""
