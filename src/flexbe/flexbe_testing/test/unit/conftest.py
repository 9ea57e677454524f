import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # app_judge is shared with other packages
