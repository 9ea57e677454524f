"""A new package for one ability, from templates."""

from __future__ import annotations

import re
from collections.abc import Mapping

from remodel_states.core.state_source import snake_case

_SUFFIX = ".in"
_ABILITY = re.compile(r"([A-Z][a-z0-9]+){2,}")
_PACKAGE = re.compile(r"[a-z][a-z0-9_]+")


def name_problems(ability: str, package: str) -> list[str]:
    """Return what is wrong with the names of an ability and its package."""
    problems = []
    if not _ABILITY.fullmatch(ability):
        problems.append(f"ability {ability!r}: allowed: a verb and a noun such as CrimpFerrule")
    if not _PACKAGE.fullmatch(package):
        problems.append(f"package {package!r}: allowed: lower case such as crimp_ferrule")
    return problems


def package_files(
    templates: Mapping[str, str], ability: str, package: str, code: int
) -> dict[str, str]:
    """Return the files of the package: path in it -> text.

    Args:
        templates: path, with the suffix ".in" -> text.
        ability: name of the action, such as "CrimpFerrule".
        package: name of the package.
        code: number of its first error code.
    """
    module = snake_case(ability)
    values = {
        "ability": ability,
        "package": package,
        "module": module,
        "topic": ability.lower(),
        "title": module.replace("_", " ").title(),
        "code": f"{module.upper()}_FAILED",
        "number": str(code),
    }
    return {
        _filled(path, values).removesuffix(_SUFFIX): _filled(text, values)
        for path, text in templates.items()
    }


def _filled(text: str, values: Mapping[str, str]) -> str:
    return re.sub(r"@(\w+)@", lambda match: values[match[1]], text)
