"""States that end as a script says."""
