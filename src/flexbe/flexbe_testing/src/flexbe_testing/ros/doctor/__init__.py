"""Import and construct a user's states and behaviors, in a process of its own."""
