"""States of general use, one per module."""
