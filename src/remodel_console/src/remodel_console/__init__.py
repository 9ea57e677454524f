"""The operator console; so far the part that needs no screen."""
