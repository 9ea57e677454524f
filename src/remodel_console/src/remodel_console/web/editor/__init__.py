"""The page on which charts are edited, and its panels."""
