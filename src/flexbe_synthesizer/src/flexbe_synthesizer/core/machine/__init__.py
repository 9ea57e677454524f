"""Plain FlexBE behaviors as values: expanded from charts, read from files, and folded back."""
