"""Test cases and recorded messages on disk."""
