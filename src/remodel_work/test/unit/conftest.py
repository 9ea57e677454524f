import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # panels are shared with other packages
