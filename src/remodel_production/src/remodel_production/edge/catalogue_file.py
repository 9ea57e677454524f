"""Read the catalogue from its YAML file."""

from pathlib import Path

import yaml

from remodel_production.core.catalogue import Catalogue, catalogue_from
from remodel_production.errors import CatalogueError


def read_catalogue(path: Path) -> Catalogue:
    """Return the catalogue in a file.

    Raises:
        CatalogueError: if the file is no YAML or not of the catalogue's form.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise CatalogueError(f"{path}: {error}") from error
    return catalogue_from(data)
