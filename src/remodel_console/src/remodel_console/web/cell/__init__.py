"""The cell on pages: in three dimensions, and as its cameras see it."""
