import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # drawn pictures are shared with other packages
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_work/test"))
