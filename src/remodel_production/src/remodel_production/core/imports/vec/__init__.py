"""Import harnesses of the Vehicle Electric Container."""
