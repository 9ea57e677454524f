"""FlexBE states of the REMODEL abilities, one per module."""
