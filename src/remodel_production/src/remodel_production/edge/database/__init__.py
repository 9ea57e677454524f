"""The production database: its models and versions, and orders as rows."""
