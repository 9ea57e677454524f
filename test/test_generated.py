"""What is generated from the tables in remodel_msgs/config is committed as it is generated now."""

import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).parents[1] / "tools" / "generate.py"


def test_generated_files_are_those_of_the_tables():
    done = subprocess.run([sys.executable, TOOL, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, f"run make generate\n{done.stdout}{done.stderr}"
