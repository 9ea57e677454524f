"""What the tests of this package share with those of others."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_tasks/test"))
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_production/test"))

from databases import postgres_url, url  # noqa: F401 - fixtures
