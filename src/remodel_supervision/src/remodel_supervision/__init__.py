"""Supervision: runs of orders, recovery from failures, learning, and leases."""
