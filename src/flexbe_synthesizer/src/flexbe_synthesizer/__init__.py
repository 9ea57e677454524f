"""State charts in XML, checked and written as FlexBE behaviors."""
