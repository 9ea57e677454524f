"""Where the charts of behaviors are, in a source, devel or install space."""

from pathlib import Path

import rospkg


def behavior_charts() -> Path:
    """Return the folder of the charts that remodel_behaviors ships."""
    return Path(rospkg.RosPack().get_path("remodel_behaviors")) / "charts"
