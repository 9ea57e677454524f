"""What a cell with a real robot needs."""
