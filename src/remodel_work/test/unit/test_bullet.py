"""PyBullet prints nothing of its own."""

import subprocess
import sys


def test_loading_and_connecting_print_nothing():
    program = "from remodel_work.edge.bullet import connect; connect(); print('ready')"
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "ready\n", "")
