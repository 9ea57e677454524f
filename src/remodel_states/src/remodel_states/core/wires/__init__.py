"""What planner and cell both know of wires."""
