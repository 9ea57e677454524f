"""The workpiece: the panel with its components and fixtures, and the wires on it."""
