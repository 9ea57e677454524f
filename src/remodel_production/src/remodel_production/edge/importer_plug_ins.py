"""Importers of other packages, which Python finds by their entry points.

A package adds a design format with an entry point of the group `remodel_production.importers`,
which names a `DesignFormat`:

    [project.entry-points."remodel_production.importers"]
    panel_json = "panel_json:PANEL_JSON"
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.design_format import (
    DesignFile,
    DesignFormat,
    Join,
    ReadModules,
)
from remodel_production.core.imports.formats import built_in_formats
from remodel_production.core.imports.shared.account import Imported
from remodel_production.core.imports.shared.modules import Asked
from remodel_production.core.imports.wire_lists.mapping import WireListMapping
from remodel_production.errors import DesignError, PlannerError, blamed

GROUP = "remodel_production.importers"

_Result = TypeVar("_Result")


def design_formats(mappings: Sequence[WireListMapping]) -> tuple[DesignFormat, ...]:
    """Return the formats of this package, then those of plug-ins in the order of their names.

    Args:
        mappings: of the wire lists that are known.

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
        loaded: object = _guarded(point, point.load)
    if not isinstance(loaded, DesignFormat):
        raise DesignError(
            f"{_where(point)}: {type(loaded).__name__} found; needed: a DesignFormat "
            "(remodel_production.core.imports.design_format)"
        )

    def fits(file: DesignFile) -> bool:
        return _guarded(point, lambda: loaded.fits(file))

    def read(data: bytes, name: str, source: str, catalogue: Catalogue) -> Imported:
        return _imported(point, lambda: loaded.read(data, name, source, catalogue))

    return replace(
        loaded,
        fits=fits,
        read=read,
        read_modules=_modules_reader(point, loaded.read_modules),
        join=_joiner(point, loaded.join),
    )


def _modules_reader(point: EntryPoint, read: ReadModules | None) -> ReadModules | None:
    """Return what reads modules, whose errors are reported with the plug-in's name."""
    if read is None:
        return None

    def read_modules(
        data: bytes, name: str, source: str, catalogue: Catalogue, asked: Asked
    ) -> Imported:
        return _imported(point, lambda: read(data, name, source, catalogue, asked))

    return read_modules


def _joiner(point: EntryPoint, join: Join | None) -> Join | None:
    """Return what joins files, whose errors are reported with the plug-in's name."""
    if join is None:
        return None
    return lambda before, data: _guarded(point, lambda: join(before, data))


def _imported(point: EntryPoint, call: Callable[[], object]) -> Imported:
    imported = _guarded(point, call)
    if not isinstance(imported, Imported):
        raise DesignError(
            f"{_where(point)}: its `read` returned {type(imported).__name__}; needed: an "
            "Imported (remodel_production.core.imports.shared.account)"
        )
    return imported


def _guarded(point: EntryPoint, call: Callable[[], _Result]) -> _Result:
    try:
        return call()
    except PlannerError:
        raise
    except Exception as error:
        raise DesignError(
            f"{_where(point)}: {type(error).__name__}: {error}; correct the plug-in, or uninstall "
            "it"
        ) from error


def _where(point: EntryPoint) -> str:
    package = f" of package {point.dist.name}" if point.dist else ""
    return f"importer plug-in {point.name} = {point.value}{package}"
