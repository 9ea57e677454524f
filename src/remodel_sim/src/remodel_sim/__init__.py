"""The simulated wiring cell and its ability servers."""
