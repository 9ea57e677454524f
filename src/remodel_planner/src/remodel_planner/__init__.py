"""The planner as one command, and what launches it with a cell."""
