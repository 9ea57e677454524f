"""Where this package's data files are, in a source, devel or install space."""

from pathlib import Path

import rospkg

_PACKAGE = "remodel_planner"


def catalogue_file() -> Path:
    """Return the path of the catalogue."""
    return _folder() / "config" / "catalogue.yaml"


def use_case_folder() -> Path:
    """Return the folder of the use cases."""
    return _folder() / "config" / "use_cases"


def use_case_schema() -> Path:
    """Return the path of the use cases' schema."""
    return _folder() / "config" / "use_case.schema.json"


def wire_list_mappings() -> list[Path]:
    """Return the paths of the mappings of wire lists."""
    return sorted((_folder() / "config" / "wire_lists").glob("*.yaml"))


def report_template() -> Path:
    """Return the path of the report's template."""
    return _folder() / "templates" / "report.html.j2"


def behavior_charts() -> Path:
    """Return the folder of the charts that remodel_behaviors ships."""
    return Path(rospkg.RosPack().get_path("remodel_behaviors")) / "charts"


def _folder() -> Path:
    return Path(rospkg.RosPack().get_path(_PACKAGE))
