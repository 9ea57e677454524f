"""Behaviors and states that engine_conformance has an engine run."""
