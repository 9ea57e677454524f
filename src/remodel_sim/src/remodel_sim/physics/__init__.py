"""The physics of the cell: the only folder that imports PyBullet."""
