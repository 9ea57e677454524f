"""Files of a user's workspace and of this engine."""
