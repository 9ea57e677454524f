"""Read the tables of abilities and faults, and write what is generated from them."""
