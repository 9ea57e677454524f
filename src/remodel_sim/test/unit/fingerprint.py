"""Print a hash of what a short run leaves: the same for the same seed and goals, in any process."""

import hashlib
import re
import subprocess
import sys

import place_wire as do
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.cell import Cell
from remodel_work.panel import WireEnd


def fingerprint():
    """Locate, pick and insert an end; return a hash of every joint and node."""
    made = Cell(SimulatedPlant(panel(), seed=7))
    made.feed("W1", "A")
    do.insert(made, "W1", WireEnd.A, "X1", terminal="1", socket=do.locate(made, "X1", "1"))
    state = made.plant.live.cable.nodes().tobytes() + made.plant.robots["robot_1"].joints.tobytes()
    made.close()
    return hashlib.sha256(state).hexdigest()


def fingerprint_elsewhere():
    """Return the fingerprint of a process of its own."""
    paths = [path for path in sys.path if path]
    script = (
        f"import sys; sys.path[:0] = {paths!r}; import fingerprint as f; print(f.fingerprint())"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    # PyBullet prints lines of its own, before or after.
    return re.search(r"^\w{64}$", run.stdout, re.M)[0]
