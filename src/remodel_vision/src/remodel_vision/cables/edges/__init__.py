"""Cross-section profiles: the edges of cables, their refined centrelines and the confidence."""
