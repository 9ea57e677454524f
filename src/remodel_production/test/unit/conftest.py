"""What the tests of this package share."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import pytest
from databases import postgres_url, url  # noqa: F401 - fixtures

from remodel_production.edge.database.production_database import ProductionDatabase


@pytest.fixture
def database(url):  # noqa: F811 - the fixture
    database = ProductionDatabase(url)
    yield database
    database.close()
