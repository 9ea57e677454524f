"""Behaviors that the benchmarks of the engine time."""
