"""The commands that run orders, and tell of runs."""
