"""What the tests of this package share with those of others."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_planner/test/unit"))
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_production/test"))
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_tasks/test"))
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_supervision/test/unit"))

import pytest
from databases import postgres_url, url  # noqa: F401 - fixtures


@pytest.fixture
def database(tmp_path):
    """Return the URL of a database that is not there yet."""
    return f"sqlite:///{tmp_path}/production.sqlite"
