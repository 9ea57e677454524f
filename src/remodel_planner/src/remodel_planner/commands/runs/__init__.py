"""The commands that run orders and report on runs."""
