"""Commands for a cell with a real robot."""
