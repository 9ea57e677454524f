"""Where this package's data files are, in a source, devel or install space."""

from pathlib import Path

import rospkg

_PACKAGE = "remodel_planning"


def use_case_folder() -> Path:
    """Return the folder of the use cases."""
    return _folder() / "config" / "use_cases"


def use_case_schema() -> Path:
    """Return the path of the use cases' schema."""
    return _folder() / "config" / "use_case.schema.json"


def _folder() -> Path:
    return Path(rospkg.RosPack().get_path(_PACKAGE))
