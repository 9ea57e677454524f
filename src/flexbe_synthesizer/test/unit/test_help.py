"""Programs that serve something say how they are started, and serve nothing, if asked for help."""

import subprocess
import sys
from pathlib import Path

import pytest

NODES = Path(__file__).parents[2] / "nodes"


@pytest.mark.parametrize("node", ["synthesis_server"])
def test_help_starts_nothing(node, monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1/")  # nobody is there
    told = subprocess.run(
        [sys.executable, NODES / node, "--help"], capture_output=True, text=True, timeout=60
    )
    assert (told.returncode, told.stderr) == (0, "")
    assert told.stdout.startswith(f"usage: {node}")
    refused = subprocess.run(
        [sys.executable, NODES / node, "--nonsense"], capture_output=True, text=True, timeout=60
    )
    assert refused.returncode == 2
