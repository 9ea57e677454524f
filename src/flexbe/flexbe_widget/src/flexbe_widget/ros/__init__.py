"""Requests to the engine, and what it answers."""
