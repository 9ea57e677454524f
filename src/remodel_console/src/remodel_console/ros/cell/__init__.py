"""The cell, as the console sees it: its cameras, and where its robots and wires are."""
