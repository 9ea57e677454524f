"""Colours of what is beside wires in the cell, as sRGB in 0 to 1."""

from remodel_states.core.wires.wire_colours import Rgb

# The collar that covers each ferrule: a hue that no wire has, so that loose ends are found among
# wires of any colour.
FERRULE_RGB: Rgb = (0.95, 0.02, 0.62)

# The mounting plate, near RAL 7035 (light grey).
PLATE_RGB: Rgb = (0.80, 0.82, 0.80)
