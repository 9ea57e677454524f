"""The kernel's library, and the clock of a search."""
