"""What a cell can do, in the words of its file."""
