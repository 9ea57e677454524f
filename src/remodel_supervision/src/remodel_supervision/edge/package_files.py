"""Where this package's data files are, in a source, devel or install space."""

from pathlib import Path

import rospkg

_PACKAGE = "remodel_supervision"


def behavior_charts() -> Path:
    """Return the folder of the charts that remodel_behaviors ships."""
    return Path(rospkg.RosPack().get_path("remodel_behaviors")) / "charts"


def _folder() -> Path:
    return Path(rospkg.RosPack().get_path(_PACKAGE))
