"""The chart that is edited: its changes, its drawing, and what the checks say about it."""
