"""Behaviors and states for the tests of the engine."""
