"""The behavior that runs, as the engine reports it, and the orders to the engine."""
