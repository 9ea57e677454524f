"""Proofs that a chart can run, or everything that is wrong with it."""
