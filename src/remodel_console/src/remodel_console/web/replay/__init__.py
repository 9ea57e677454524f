"""The page of recorded runs, and its panels."""
