"""The room for files."""
