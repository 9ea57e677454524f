"""Migrations of the production knowledge database, run by edge/database_versions.py."""
