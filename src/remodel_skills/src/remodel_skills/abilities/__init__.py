"""What the robot can do: one ability in each module, found by its decorator (ability.py)."""
