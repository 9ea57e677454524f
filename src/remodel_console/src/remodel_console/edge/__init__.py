"""The charts and behaviors on the disk."""
