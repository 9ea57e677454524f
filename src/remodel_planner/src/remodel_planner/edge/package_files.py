"""Where this package's data files are, in a source, devel or install space."""

from pathlib import Path

import rospkg

_PACKAGE = "remodel_planner"


def report_template() -> Path:
    """Return the path of the report's template."""
    return _folder() / "templates" / "report.html.j2"


def _folder() -> Path:
    return Path(rospkg.RosPack().get_path(_PACKAGE))
