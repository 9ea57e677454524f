"""How wires bend: discrete rods, and the forms in which they hang."""
