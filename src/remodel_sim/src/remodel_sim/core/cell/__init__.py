"""The cell around the panel: its design, its faults and who may command it."""
