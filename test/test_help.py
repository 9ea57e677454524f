"""Nodes print how they are started, and start nothing, when they are asked for help."""

import subprocess
import sys
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src"
NODES = [
    "flexbe_synthesizer/nodes/synthesis_server",
    "remodel_console/nodes/command_server",
    "remodel_states/nodes/fake_abilities",
    "remodel_states/nodes/fake_cell",
]


@pytest.mark.parametrize("node", NODES)
def test_help_starts_nothing(node, monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1/")  # no master is there
    asked = subprocess.run(
        [sys.executable, SRC / node, "--help"], capture_output=True, text=True, timeout=60
    )
    assert (asked.returncode, asked.stderr) == (0, "")
    assert asked.stdout.startswith(f"usage: {Path(node).name}")
    refused = subprocess.run(
        [sys.executable, SRC / node, "--nonsense"], capture_output=True, text=True, timeout=60
    )
    assert refused.returncode == 2
