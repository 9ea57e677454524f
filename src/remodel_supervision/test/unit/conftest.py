"""What the tests of this package share with those of others."""

import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_supervision/test/unit"))
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_production/test"))
sys.path.insert(0, str(Path(__file__).parents[3] / "flexbe/flexbe_testing/test"))

from databases import postgres_url, url  # noqa: F401 - fixtures
from house import HOUSE
from supervisor_bench import Bench

from remodel_production.edge.database.production_database import ProductionDatabase


@pytest.fixture(scope="session")
def house_file(tmp_path_factory):
    """Return an SQLite file with the order HOUSE, which is quicker to copy than to migrate."""
    file = tmp_path_factory.mktemp("house") / "production.sqlite"
    database = ProductionDatabase(f"sqlite:///{file}")
    database.add_order(HOUSE)
    database.close()
    return file


@pytest.fixture
def house_url(house_file, tmp_path):
    """Return the URL of a database with the order HOUSE."""
    return f"sqlite:///{shutil.copy(house_file, tmp_path)}"


@pytest.fixture
def make_bench(house_url):
    """Return what makes a supervisor of the order HOUSE, faking all beside it but the database."""
    made = []

    def make(**options):
        made.append(Bench(house_url, **options))
        return made[-1]

    yield make
    for bench in made:
        bench.database.close()


@pytest.fixture
def bench(make_bench):
    return make_bench()


@pytest.fixture
def attended_bench(make_bench):
    return make_bench(attended=True)
