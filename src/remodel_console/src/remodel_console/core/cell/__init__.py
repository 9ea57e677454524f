"""The cell in three dimensions: what its robots look like, and where everything is."""
