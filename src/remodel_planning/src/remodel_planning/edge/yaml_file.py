"""YAML documents on disk."""

from __future__ import annotations

from pathlib import Path

import yaml

from remodel_production.edge.text_file import read_text
from remodel_production.errors import InstanceError


def read_yaml(file: Path) -> object:
    """Return the parsed document of a file.

    Raises:
        InstanceError: if it cannot be read or is no YAML, with the place.
    """
    try:
        return yaml.load(read_text(file), _Loader)
    except yaml.YAMLError as error:
        raise InstanceError(f"is no YAML: {' '.join(str(error).split())}") from error
    except RecursionError as error:
        raise InstanceError("is nested too deeply") from error


# The same loader, in C where libyaml is there.
_Loader: type = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
