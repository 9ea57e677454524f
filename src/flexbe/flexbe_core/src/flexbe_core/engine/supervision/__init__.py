"""What an operator has in force over a run: commands, and what they allow a state to do."""
