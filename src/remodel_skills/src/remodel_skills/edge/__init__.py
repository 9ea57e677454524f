"""Access to files."""
