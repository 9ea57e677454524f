"""The command server."""
