"""Bodies of wires: live ones that bend and parked ones that stay as they are."""
