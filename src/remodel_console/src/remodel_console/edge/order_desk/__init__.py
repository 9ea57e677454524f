"""Drafts of orders on disk, and the processes that read and plan them."""
