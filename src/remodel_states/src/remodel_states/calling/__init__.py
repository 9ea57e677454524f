"""What `AbilityCall` uses: the requests to a supervisor, and the texts of a record."""
