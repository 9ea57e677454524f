"""Where things are on the board that is wired: the plate of a cabinet, or a formboard."""
