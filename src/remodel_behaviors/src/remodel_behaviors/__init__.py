"""Behaviors synthesized from the charts in charts/."""
