"""Ability servers for robots whose controllers take poses and publish wrenches."""
