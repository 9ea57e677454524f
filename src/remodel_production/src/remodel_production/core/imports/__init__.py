"""Design files in, orders out: one file for each format.

Each importer returns an order with an account of what it read, assumed and left out, or raises
DesignError. None of them touches the disk.
"""
