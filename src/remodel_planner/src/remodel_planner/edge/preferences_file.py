"""Read preferences from YAML."""

from __future__ import annotations

from pathlib import Path

import yaml

from remodel_planner.edge.text_file import read_text
from remodel_planner.errors import InstanceError


def read_preferences(file: Path) -> object:
    """Return the parsed document of a YAML file.

    Raises:
        InstanceError: if it cannot be read or is no YAML, with the place.
    """
    try:
        return yaml.safe_load(read_text(file))
    except yaml.YAMLError as error:
        raise InstanceError(f"is no YAML: {' '.join(str(error).split())}") from error
