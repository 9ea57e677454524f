"""Test states and behaviors with cases in YAML."""
