import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # scripted_device is shared by tests
for package in ("remodel_vision", "remodel_work"):
    sys.path.insert(0, str(Path(__file__).parents[3] / package / "test"))
