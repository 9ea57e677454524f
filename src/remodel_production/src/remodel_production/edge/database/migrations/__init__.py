"""Migrations of the production database, run by edge/database/production_database.py."""
