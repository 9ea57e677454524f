"""The design of a cell: robots, magazine, feeder, scrap bin."""
