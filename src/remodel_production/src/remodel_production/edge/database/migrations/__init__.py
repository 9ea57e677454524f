"""Migrations of the production database, run by edge/database/database_versions.py."""
