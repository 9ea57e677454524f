"""The relay between two actions."""
