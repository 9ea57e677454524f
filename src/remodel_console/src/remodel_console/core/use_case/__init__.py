"""Runs of an order: as the supervisor publishes them, and as they were recorded."""
