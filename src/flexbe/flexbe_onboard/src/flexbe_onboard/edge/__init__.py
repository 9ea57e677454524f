"""Sources of behaviors: read, checked, imported."""
