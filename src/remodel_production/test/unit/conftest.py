"""What the tests of this package share."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from databases import postgres_url, url  # noqa: F401 - fixtures
