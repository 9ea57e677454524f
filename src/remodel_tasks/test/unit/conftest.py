"""What the tests of this package share with those of others."""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_tasks/test"))
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_production/test"))

import pytest
from databases import postgres_url, url  # noqa: F401 - fixtures

from flexbe_synthesizer.edge.package_path import find_packages, read_library


@pytest.fixture(scope="session")
def library():
    """Return the states of `remodel_states`, with which charts are checked."""
    packages, _ = find_packages(os.environ["ROS_PACKAGE_PATH"])
    return read_library([p for p in packages if p.name == "remodel_states"])[0]
