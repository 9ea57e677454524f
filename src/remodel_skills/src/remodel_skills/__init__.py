"""What makes a wire go in: the skills of a cell, on any robot that offers the device port."""
