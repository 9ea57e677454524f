"""The page of the order that the cell works on, and its panels."""
