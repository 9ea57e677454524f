"""Examine the text of one file."""

from __future__ import annotations

from dataclasses import dataclass

from flexbe_testing.core.app.behavior import Known
from flexbe_testing.core.doctor.app import check_app
from flexbe_testing.core.doctor.blocking import check_blocking
from flexbe_testing.core.doctor.finding import Finding
from flexbe_testing.core.doctor.imports import Surface, check_imports
from flexbe_testing.core.doctor.internals import check_internals
from flexbe_testing.core.doctor.module import Kind, Module, parse_module
from flexbe_testing.core.doctor.python2 import check_python2, unparsable


@dataclass(frozen=True)
class Engine:
    """What users' code can use of this engine.

    Attributes:
        surface: the names of each module of flexbe_core.
        attributes: the names that states and containers have.
    """

    surface: Surface
    attributes: frozenset[str]


def examine(
    file: str, text: str, engine: Engine, known: Known
) -> tuple[list[Finding], Module | None]:
    """Return the findings in a file, and the parsed file if it is Python 3.

    Args:
        file: its path.
        text: its source.
        engine: what this engine has.
        known: the states and behaviors that the FlexBE App would find.
    """
    try:
        module = parse_module(file, text)
    except SyntaxError as error:
        return [unparsable(file, text, error)], None
    found = [*check_imports(module, engine.surface), *check_python2(module)]
    found += [*check_blocking(module), *check_internals(module, engine.attributes)]
    return [*found, *check_app(module, known)], module


def count(module: Module, kind: Kind) -> int:
    """Return how many classes of a kind a file has."""
    return sum(found.kind is kind for found in module.classes)
