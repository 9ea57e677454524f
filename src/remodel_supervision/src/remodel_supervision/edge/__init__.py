"""The rooms that touch disk, database and network."""
