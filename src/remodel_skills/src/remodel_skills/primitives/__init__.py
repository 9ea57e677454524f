"""Motions, observations, grasps and pushes that abilities are composed of."""
