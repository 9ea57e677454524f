"""What supervisor, planner and console report of an order and its run to each other."""
