"""Design files, their mappings and placements, data of packages, and importers of others.

A package adds a design format with an entry point of the group `remodel_production.importers`,
which names a `DesignFormat`:

    [project.entry-points."remodel_production.importers"]
    panel_json = "panel_json:PANEL_JSON"
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import ParamSpec, TypeVar

import rospkg
import yaml

from remodel_production.core.catalogue import Catalogue, catalogue_from
from remodel_production.core.imports.assembly import with_placement
from remodel_production.core.imports.design_format import DesignFormat
from remodel_production.core.imports.documents import decode
from remodel_production.core.imports.formats import built_in_formats
from remodel_production.core.imports.values import Imported
from remodel_production.core.imports.wire_list_mapping import WireListMapping, mapping_from
from remodel_production.core.production import Ability, AbilityParameter
from remodel_production.errors import (
    CatalogueError,
    DesignError,
    PlannerError,
    blamed,
)
from remodel_states.core.tables import TableError, schema_problems
from remodel_states.core.wires import MaterialError
from remodel_states.edge import exported_tables


def package_folder(package: str) -> Path:
    """Return the folder of a package on the ROS package path."""
    return Path(rospkg.RosPack().get_path(package))


def catalogue_file() -> Path:
    """Return the path of the catalogue."""
    return package_folder("remodel_production") / "config/catalogue.yaml"


def wire_list_mappings() -> list[Path]:
    """Return the paths of the mappings of wire lists."""
    return sorted((package_folder("remodel_production") / "config/wire_lists").glob("*.yaml"))


def read_catalogue(path: Path) -> Catalogue:
    """Return the catalogue in a file, with the wire materials that the cell has, too.

    Raises:
        CatalogueError: if the file is no YAML or not of the catalogue's form, with each problem, or
            a table of wire materials cannot be read.
    """
    try:
        data = yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)
    except (OSError, yaml.YAMLError) as error:
        raise CatalogueError(f"{path}: {error}") from error
    schema = package_folder("remodel_production") / "config/catalogue.schema.json"
    problems = list(schema_problems(data, json.loads(schema.read_text(encoding="utf-8"))))
    if problems:
        raise CatalogueError(f"{path}: " + "\n  ".join(problems))
    try:
        materials = exported_tables.read_wire_materials()
    except MaterialError as error:
        raise CatalogueError(str(error)) from error
    with blamed(path):
        return catalogue_from(data, materials)


def read_abilities() -> tuple[Ability, ...]:
    """Return the abilities of the tables that packages export, by name.

    Raises:
        PlannerError: if a table cannot be read.
    """
    try:
        rows = exported_tables.read_abilities()
    except TableError as error:
        raise PlannerError(str(error)) from error
    return tuple(
        Ability(
            name,
            row.action.title,
            tuple(AbilityParameter(f.name, f.type, f.text) for f in row.action.goal),
        )
        for name, row in sorted(rows.items())
    )


# The largest example of QElectroTech has 3.5 MB, a vehicle's harness as KBL some 50 MB.
_MOST_BYTES = 100_000_000


def read_design(file: Path) -> bytes:
    """Return the content of a file.

    Raises:
        DesignError: if it cannot be read, or is too large for any design.
    """
    try:
        with file.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
    except OSError as error:
        raise DesignError(f"{file}: cannot be read: {error.strerror}") from error
    if len(data) > _MOST_BYTES:
        raise DesignError(
            f"{file}: is larger than {_MOST_BYTES // 1_000_000} MB, the most that is read: is it a "
            "design file?"
        )
    return data


def read_mappings(file: Path | None) -> tuple[WireListMapping, ...]:
    """Return the mapping in a file, or those of the package if there is none.

    Raises:
        DesignError: naming the file and the line if a mapping is malformed.
    """
    files = [file] if file is not None else wire_list_mappings()
    return tuple(_read_mapping(each) for each in files)


def read_placement(file: Path | None, catalogue: Catalogue) -> Catalogue:
    """Return a catalogue in which the placement in a file counts first; itself if there is none.

    Raises:
        DesignError: naming the file and the line if the placement is malformed.
    """
    if file is None:
        return catalogue
    data = read_design(file)
    with blamed(file):
        return with_placement(catalogue, decode(data)[0])


def _read_mapping(file: Path) -> WireListMapping:
    data = read_design(file)
    with blamed(file):
        return mapping_from(decode(data)[0])


GROUP = "remodel_production.importers"

_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")


def design_formats(mappings: Sequence[WireListMapping]) -> tuple[DesignFormat, ...]:
    """Return the formats of this package, then those of plug-ins in the order of their names.

    Raises:
        DesignError: naming the entry point that cannot be loaded, is no DesignFormat, or has the
            name of another format.
    """
    formats = {form.name: form for form in built_in_formats(mappings)}
    # One for each place: a package may be on Python's path twice.
    found = {(point.name, point.value): point for point in entry_points(group=GROUP)}
    for _, point in sorted(found.items()):
        form = _load(point)
        if form.name in formats:
            raise DesignError(
                f"{_where(point)}: there is a format {form.name!r} already: rename this one"
            )
        formats[form.name] = form
    return tuple(formats.values())


def _load(point: EntryPoint) -> DesignFormat:
    """Return the format of an entry point, whose errors are reported with the plug-in's name."""
    with blamed(_where(point)):
        loaded: object = _guarded(point, point.load)()
    if not isinstance(loaded, DesignFormat):
        raise DesignError(
            f"{_where(point)}: {type(loaded).__name__} found; needed: a DesignFormat "
            "(remodel_production.core.imports.design_format)"
        )

    return replace(
        loaded,
        fits=_guarded(point, loaded.fits),
        read=_reader(point, loaded.read),
        read_modules=loaded.read_modules and _reader(point, loaded.read_modules),
        join=loaded.join and _guarded(point, loaded.join),
    )


def _reader(point: EntryPoint, read: Callable[_Given, object]) -> Callable[_Given, Imported]:
    """Return a guarded function that returns an import."""

    def reading(*given: _Given.args, **named: _Given.kwargs) -> Imported:
        imported = _guarded(point, read)(*given, **named)
        if not isinstance(imported, Imported):
            raise DesignError(
                f"{_where(point)}: its `read` returned {type(imported).__name__}; needed: an "
                "Imported (remodel_production.core.imports.values)"
            )
        return imported

    return reading


def _guarded(point: EntryPoint, call: Callable[_Given, _Result]) -> Callable[_Given, _Result]:
    """Return a function whose errors are reported with the plug-in's name."""

    def guarded(*given: _Given.args, **named: _Given.kwargs) -> _Result:
        try:
            return call(*given, **named)
        except PlannerError:
            raise
        except Exception as error:
            raise DesignError(
                f"{_where(point)}: {type(error).__name__}: {error}; correct the plug-in, or "
                "uninstall it"
            ) from error

    return guarded


def _where(point: EntryPoint) -> str:
    package = f" of package {point.dist.name}" if point.dist else ""
    return f"importer plug-in {point.name} = {point.value}{package}"
