"""What the engine reads of a behavior's definition."""
