"""What wires there are on a plate, by depth pictures from above."""
