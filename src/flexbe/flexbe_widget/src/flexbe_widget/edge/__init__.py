"""Files that values come from."""
