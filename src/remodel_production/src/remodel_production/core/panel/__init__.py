"""The panel of a cell: where components are placed, and how long wires are."""
