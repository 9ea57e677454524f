"""Files that the cell reads and writes."""
