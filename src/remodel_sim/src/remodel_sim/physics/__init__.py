"""The edge of the simulation: the only room that knows PyBullet."""
