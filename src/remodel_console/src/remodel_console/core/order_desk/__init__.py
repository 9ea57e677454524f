"""An order before it is stored: what the planner's commands say of a design file."""
