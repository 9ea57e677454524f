"""Find in source text what would differ on this engine; nothing is imported or executed."""
