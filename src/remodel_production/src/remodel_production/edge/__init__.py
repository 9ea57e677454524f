"""The rooms that touch disk and database."""
