"""Plain FlexBE behaviors as values: lowered from charts, read from files, and lifted to charts."""
