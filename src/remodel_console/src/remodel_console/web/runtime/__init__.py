"""The page of the behavior that runs, and its panels."""
